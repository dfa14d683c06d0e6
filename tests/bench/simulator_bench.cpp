// Speed of the simulated arena beside a bare reference and a textbook ODE world, alternating in one process. Prints
// robot-seconds per second of processor time. All robots walk at random and send; contacts have friction 0.3. At the
// end it sums up: shares, time per part, how deep contacts went and how far anything came out of the plane. The bare
// reference is compiled like the arena; with -march=native -ffast-math it was up to 6 % faster. It runs at several
// times the floor that keeps it honest (0.8 M, dense 0.6 M).
// `step_share` is how much of "ode" is ODE's own step: the linker puts a clock around dWorldQuickStep.
//   bench_simulator [--benchmark_filter=...] [--benchmark_repetitions=5]
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <ode/ode.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "sim_ode/contact_world.hpp"
#include "sim_ode/host/robot_host.hpp"
#include "sim_ode/infrared_exchange.hpp"
#include "sim_ode/ode_arena.hpp"
#include "sim_ode/robot_infrared.hpp"
#include "sim_ode/start_places.hpp"
#include "tests/bench/bare_swarm.hpp"
#include "tests/bench/textbook_swarm.hpp"

// Seconds spent in ODE's step. The link option --wrap=dWorldQuickStep sends every call here.
static double step_s = 0;
extern "C" int __real_dWorldQuickStep(dWorldID world, dReal seconds);
extern "C" int __wrap_dWorldQuickStep(dWorldID world, dReal seconds) {
  const auto begin = std::chrono::steady_clock::now();
  const int result = __real_dWorldQuickStep(world, seconds);
  step_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

namespace arkmesh::bench {
namespace {

struct Size {
  int robots;
  int per_m2;
  double side_m() const { return std::sqrt(static_cast<double>(robots) / per_m2); }
  std::string name() const { return fmt::format("{}_at_{}", robots, per_m2); }
};
constexpr Size sizes[] = {{100, 48}, {1000, 48}, {10000, 48}, {1000, 400}};
constexpr Size further[] = {{100, 400}, {10000, 400}};  // for comparisons with other programs
const std::string program = std::string(ARKMESH_SOURCE_DIR) + "/tests/bench/controllers/walk_and_talk.c";
constexpr double warm_up_s = 20;

// Processor time of this thread: other processes' turns do not count.
double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Steps until the benchmark ends; about `each_s` x robots each.
template <class Step>
void measure(benchmark::State& state, const Size& size, double each_s, Step&& step) {
  std::uint64_t steps = 0;
  for (auto _ : state) {
    step();
    ++steps;
  }
  state.counters["robot_s_per_cpu_s"] =
      benchmark::Counter(static_cast<double>(steps) * each_s * size.robots, benchmark::Counter::kIsRate);
}

void bare(benchmark::State& state, Size size) {
  static std::map<std::string, std::unique_ptr<BareSwarm>> kept;
  auto& swarm = kept[size.name()];
  if (!swarm) swarm = std::make_unique<BareSwarm>(size.robots, static_cast<float>(size.side_m()));
  measure(state, size, 1.0 / 32, [&] { swarm->step(); });
}

void textbook(benchmark::State& state, Size size) {
  static std::map<std::string, std::unique_ptr<TextbookSwarm>> kept;
  auto& swarm = kept[size.name()];
  if (!swarm) swarm = std::make_unique<TextbookSwarm>(size.robots, size.side_m());
  measure(state, size, 1.0 / 60, [&] { swarm->step(); });
}

// What a lab uses, frames and all.
void ours(benchmark::State& state, Size size, const char* solver) {
  struct Kept {
    std::unique_ptr<hal::Arena> arena;
    hal::LabTime at{0};
  };
  static std::map<std::string, Kept> kept;
  Kept& k = kept[solver + size.name()];
  if (!k.arena) {
    const auto config = hal::Config::from_text(
        fmt::format("[arena]\nwidth_m = {0}\nheight_m = {0}\nrobots = {1}\n[arena.ode]\ncontroller = \"{2}\"\n"
                    "solver = \"{3}\"\n",
                    size.side_m(), size.robots, program, solver),
        "bench");
    k.arena = sim_ode::make_ode_arena(config.root().section("arena"), "bench", 1);
    k.arena->robots().command({.kind = hal::FleetCommand::Kind::run});
    k.arena->advance_to(k.at = hal::LabTime{static_cast<std::int64_t>(warm_up_s * 1e6)});
  }
  const double began_s = cpu_s();
  step_s = 0;
  measure(state, size, 0.1, [&] {
    k.arena->advance_to(k.at += hal::LabTime{100'000});
    benchmark::DoNotOptimize(k.arena->poses().latest());
  });
  state.counters["step_share"] = step_s / (cpu_s() - began_s);
  const auto count = [&](const char* name) { return static_cast<double>(k.arena->counters()[name]); };
  if (const double solved = count("contacts.solved"); solved > 0) {
    state.counters["by_ode_share"] = count("contacts.by_ode") / solved;
    state.counters["alone_share"] = count("contacts.alone") / solved;
  }
}

// The same parts put together by hand, to see what each one takes and how true the contacts are.
void parts(benchmark::State& state, Size size) {
  using namespace sim_ode;
  static const auto places_of = [](const Size& s) {
    const SolidBodies nothing(s.side_m(), s.side_m(), {});
    StartPlaces places(s.side_m(), s.side_m(), nothing);
    places.add(s.robots, {}, hal::RandomStream(1, "bench/ode/start"));
    return places.poses();
  };
  struct Kept {
    Kept(const Size& s)
        : motors(settings, s.robots, "bench", 1),
          leds(s.robots),
          world(s.side_m(), s.side_m(), settings.contacts, 1, places_of(s)),
          host(RobotProgram::load(std::filesystem::path(program)), s.robots, motors, leds, {}, "bench", 1),
          medium(settings, s.side_m(), s.side_m(), s.robots, "bench", 1) {
      Message run;
      run.type = type_run;
      inbox.overhead.push_back({0, run, {}});
    }
    Settings settings;
    Motors motors;
    LedLights leds;
    ContactWorld world;
    RobotHost host;
    RobotInfrared medium;
    Inbox inbox;
    std::int64_t tick = 0;
    std::array<double, 5> taken_s{};  // by part
  };
  static constexpr std::array names = {"programs_us", "infrared_us", "grid_us", "motion_us", "contacts_us"};
  static std::map<std::string, std::unique_ptr<Kept>> kept;
  auto& k = kept[size.name()];
  const auto step = [&] {
    double last_s = cpu_s();
    const auto took = [&](std::size_t part) {
      const double now_s = cpu_s();
      k->taken_s[part] += now_s - last_s;
      last_s = now_s;
    };
    k->leds.end_tick();
    k->host.tick(++k->tick, k->inbox);
    k->inbox.overhead.clear();
    took(0);
    exchange_infrared(k->tick, k->world, k->host, k->medium, k->inbox.infrared);
    took(1);
    k->world.list_pairs();
    took(2);
    for (const Motors::Change& change : k->motors.end_tick()) k->world.set_velocity(change.robot, change.velocity);
    k->world.move_alone();
    took(3);
    k->world.hold_contacts();
    took(4);
  };
  if (!k) {
    k = std::make_unique<Kept>(size);
    while (k->tick * tick_us < warm_up_s * 1e6) step();
  }
  k->taken_s = {};
  const std::int64_t first = k->tick;
  measure(state, size, tick_us * 1e-6, step);
  const double robot_s = static_cast<double>(k->tick - first) * tick_us * 1e-6 * size.robots;
  for (std::size_t part = 0; part < names.size(); ++part)
    state.counters[names[part]] = k->taken_s[part] / robot_s * 1e6;
  const ContactWorld::Totals& totals = k->world.totals();
  state.counters["deepest_mm"] = totals.deepest_m * 1000;
  state.counters["deep_share"] =
      totals.contacts ? static_cast<double>(totals.deep) / static_cast<double>(totals.contacts) : 0;
  state.counters["drift_mm"] = totals.drift_m * 1000;
  state.counters["touching_share"] =
      static_cast<double>(totals.touching) / static_cast<double>(totals.steps) / size.robots;
}

// Shows what the library's own reporter shows, and keeps the medians for the summary.
class Medians final : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& context) override {
    shown_->SetOutputStream(&GetOutputStream());
    shown_->SetErrorStream(&GetErrorStream());
    return shown_->ReportContext(context);
  }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs)
      if (run.run_type == Run::RT_Iteration || run.aggregate_name == "median")
        for (const auto& [name, value] : run.counters) values_[run.run_name.function_name][name] = value.value;
    shown_->ReportRuns(runs);
  }
  void Finalize() override { shown_->Finalize(); }

  double value(const std::string& benchmark, const std::string& counter) const {
    const auto found = values_.find(benchmark);
    if (found == values_.end() || !found->second.contains(counter)) return std::nan("");
    return found->second.at(counter);
  }
  // To the error stream, so that other formats stay readable by programs.
  void summarize() const {
    const auto rate = [this](const char* what, const Size& size) {
      return value(what + ("/" + size.name()), "robot_s_per_cpu_s");
    };
    fmt::print(
        stderr,
        "\n{:>14} {:>9} {:>9} {:>14} {:>16} {:>11} {:>10} {:>9}   us per robot-second: programs infrared grid motion "
        "contacts\n",
        "robots", "ode", "fast", "share of bare", "times textbook", "deepest mm", "> 1 mm", "drift mm");
    for (const Size& size : sizes) {
      const std::string part = "parts/" + size.name();
      fmt::print(stderr, "{:>14} {:>7.0f} k {:>7.0f} k {:>14.3f} {:>16.1f} {:>11.3f} {:>9.4f}% {:>9.3g}   ",
                 size.name(), rate("ode", size) / 1e3, rate("fast", size) / 1e3,
                 rate("fast", size) / rate("bare", size), rate("ode", size) / rate("textbook", size),
                 value(part, "deepest_mm"), 100 * value(part, "deep_share"), value(part, "drift_mm"));
      for (const char* name : {"programs_us", "infrared_us", "grid_us", "motion_us", "contacts_us"})
        fmt::print(stderr, " {:.3f}", value(part, name));
      fmt::print(stderr, "\n");
    }
    fmt::print(stderr, "a robot costs {:.2f} times as much among 10000 as among 100\n",
               rate("ode", sizes[0]) / rate("ode", sizes[2]));
  }

 private:
  std::unique_ptr<benchmark::BenchmarkReporter> shown_{benchmark::CreateDefaultDisplayReporter()};
  std::map<std::string, std::map<std::string, double>> values_;
};

}  // namespace
}  // namespace arkmesh::bench

int main(int argc, char** argv) {
  using namespace arkmesh::bench;
  for (const Size& size : sizes) {
    benchmark::RegisterBenchmark(("bare/" + size.name()).c_str(), bare, size);
    benchmark::RegisterBenchmark(("textbook/" + size.name()).c_str(), textbook, size);
    benchmark::RegisterBenchmark(("ode/" + size.name()).c_str(), ours, size, "ode");
    benchmark::RegisterBenchmark(("fast/" + size.name()).c_str(), ours, size, "fast");
    benchmark::RegisterBenchmark(("parts/" + size.name()).c_str(), parts, size);
  }
  for (const Size& size : further)
    for (const char* solver : {"ode", "fast"})
      benchmark::RegisterBenchmark((std::string(solver) + "/" + size.name()).c_str(), ours, size, solver);
  // alternating, so that all see the same load of the machine
  std::vector<std::string> arguments = {argv[0], "--benchmark_enable_random_interleaving=true",
                                        "--benchmark_repetitions=5", "--benchmark_report_aggregates_only=true"};
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  int count = static_cast<int>(pointers.size());
  benchmark::Initialize(&count, pointers.data());
  if (benchmark::ReportUnrecognizedArguments(count, pointers.data())) return 2;
  Medians medians;
  benchmark::RunSpecifiedBenchmarks(&medians);
  medians.summarize();
}
