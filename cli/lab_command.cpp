// `arkmesh lab`: one lab as a process of its own, on its LCM bus; its gateway is another process.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "app/lab_session.hpp"
#include "app/neighbour_detector.hpp"
#include "arkmesh/peers_t.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "cli/progress.hpp"
#include "hal/messages.hpp"
#include "lab/result.hpp"
#include "lab/wire_check.hpp"

namespace arkmesh::cli {
namespace {

struct LabOptions {
  std::string file, out;
  std::vector<std::string> sets;
};

// What came from each peer, and what our gateway last said of the link. Counted here, because a gateway that was killed
// and started again counts from 0.
class TrafficWatch {
 public:
  explicit TrafficWatch(hal::Bus& bus)
      : arrived_(bus.subscribe("[^/]+/.+",
                               [this](std::string_view channel, std::span<const std::byte> bytes) {
                                 lab::Traffic& t = traffic_[std::string(channel.substr(0, channel.find('/')))];
                                 ++t.received_messages;
                                 t.received_bytes += bytes.size();
                               })),
        links_(bus.subscribe(hal::channel::peers, [this](std::string_view, std::span<const std::byte> bytes) {
          peers_t message;
          if (!lab::check_peers(bytes).empty() || !hal::decode(bytes, message)) return;
          for (const peer_t& peer : message.peers)
            for (const counter_t& c : peer.counters)
              traffic_[peer.lab].counters[c.name] = static_cast<std::uint64_t>(c.value);
        })) {}
  const std::map<std::string, lab::Traffic>& traffic() const { return traffic_; }

 private:
  std::map<std::string, lab::Traffic> traffic_;
  std::unique_ptr<hal::Bus::Subscription> arrived_, links_;
};

// Serves the bus for at most so long, and not beyond the moment that the arena wants to be served.
void serve(hal::Bus& bus, const hal::Arena& arena, std::chrono::milliseconds at_most) {
  using namespace std::chrono_literals;
  const hal::TimePoint now = hal::machine_time().now();
  const hal::TimePoint until = std::clamp(arena.next_service(), now, now + at_most);
  bus.drain(std::chrono::floor<std::chrono::milliseconds>(until - now));
  if (until - now < 1ms) hal::machine_time().wait_until(until);
}

int run(const LabOptions& options) {
  using namespace std::chrono_literals;
  using WallClock = std::chrono::steady_clock;
  std::ignore = operator_stops();  // from now on
  const std::filesystem::path directory =
      options.out.empty() ? app::default_run_directory() : std::filesystem::path(options.out);
  hal::Config config = hal::Config::from_file(options.file, options.sets);

  app::LabSession session(std::move(config), directory);
  hal::Bus public_bus(session.bus_url());
  app::NeighbourDetector neighbours(public_bus, session.nonce());
  neighbours.listen(std::chrono::milliseconds(1200));
  if (const std::string other = neighbours.other(); !other.empty())
    throw hal::ConfigError(fmt::format(
        "{}: bus.url = \"{}\": another lab process ('{}') is on this LCM port; give each lab a port of its own",
        options.file, session.bus_url(), other));
  session.join(public_bus);
  TrafficWatch traffic(session.bus());
  lab::LabRun& lab = session.run();

  Progress progress(session.config().lab);
  const double period_s = static_cast<double>(session.config().period.count()) * 1e-6;
  lab::WallTime wall;
  auto before = WallClock::now();
  bool moves = false;
  for (;;) {
    if (operator_stops()) lab.stop("stopped by the operator");
    const auto step = lab.step(std::chrono::duration_cast<std::chrono::microseconds>(before.time_since_epoch()));
    if (step == lab::LabRun::Step::ended) break;
    const bool waits = step == lab::LabRun::Step::waiting;
    const auto between = WallClock::now();
    if (between > before && moves)
      (waits ? wall.waiting_s : wall.computing_s) += std::chrono::duration<double>(between - before).count();
    serve(public_bus, session.arena(), waits ? 20ms : 0ms);
    before = WallClock::now();
    if (moves) (waits ? wall.waiting_s : wall.computing_s) += std::chrono::duration<double>(before - between).count();
    // From the first period until the last is complete; the lingering for slow peers afterwards is no part of the run.
    moves = lab.period() > 0 && lab.state_text() != "finished";
    progress.show(lab.period(), lab.last_period(), period_s, lab.state_text());
  }
  progress.done();
  public_bus.drain();

  lab::write_json(directory / "result.json", lab::lab_result(lab, wall, traffic.traffic()));
  while (!session.arena().end()) serve(public_bus, session.arena(), 20ms);
  if (!lab.finished()) {
    fmt::print(stderr, "arkmesh: lab {} ended early: {}\n", session.config().lab, lab.reason());
    return 1;
  }
  fmt::print("lab {} finished: {} periods, final hash {}, results in {}\n", session.config().lab, lab.period(),
             lab::hash_text(lab.final_hash()), directory.string());
  return 0;
}

}  // namespace

void add_lab_command(CLI::App& app) {
  auto options = std::make_shared<LabOptions>();
  CLI::App* command = add_command(app, "lab");
  command->add_option("file", options->file, "The lab's configuration file")->required()->check(CLI::ExistingFile);
  command->add_option("--out", options->out, "Folder for the results (default runs/DATE-TIME)");
  command->add_option("--set", options->sets, "Override a key: --set run.seed=7")->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh lab experiments/dhtf/shark.toml &\n  arkmesh gateway experiments/dhtf/shark.toml");
  command->callback([options] {
    hand_over_cameras({options->file}, options->sets);
    if (const int code = run(*options); code != 0) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
