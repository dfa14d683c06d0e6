// What grows over boundaries where labs do not wait for each other: real runners, whose messages come late, or not.
#include <algorithm>
#include <deque>
#include <memory>
#include <span>
#include <tuple>

#include "hal/random.hpp"
#include "scenarios/kit/resource.hpp"
#include "scenarios/kit/shared_pheromone.hpp"
#include "tests/lab/runner_bench.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

namespace {

constexpr double period_s = 0.25;

// As users write it: a stock that what all labs publish takes from, and a trail. Notes what came of both.
class Growing final : public lab::Scenario {
 public:
  void begin(lab::Lab& lab) override {
    lab.declare({.name = "taken", .length = 1, .low = 0, .high = 9});
    lab.publish("taken", {0});
    trail_.begin(lab);
  }
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override {
    lab.publish("taken", {static_cast<std::int64_t>(lab.random("taken").below(9))});
    hal::Pose at = frame.robots[0].pose;
    at.x_m = lab.random("place").uniform(-0.4, 0.4);
    trail_.lay(lab, at, 0.5);
    trail_.tell(lab);
  }
  void on_period(lab::Lab& lab) override {
    std::int64_t taken = 0;
    for (const std::string& each : lab.labs()) taken += lab.field(each, "taken").at(0);
    const auto grown = lab.grow("stock", {taken});
    for (const lab::Grown& one : grown)
      if (one.period > 0) stock_.pass(period_s, one.happened.empty() ? 0 : static_cast<int>(one.happened[0]));
    trail_.on_period(lab);
    if (!grown.empty()) seen[grown.back().period] = {stock_.stock(), trail_.field().cells()};
  }
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}
  bool finished(const lab::Lab&) const override { return false; }

  std::map<std::uint32_t, std::pair<double, std::vector<double>>> seen;  // by the owner's period

 private:
  scenarios::kit::Resource stock_{{.growth_per_s = 0.3, .rate_per_s = 0.02, .regrows_at_once_below = 0.1}};
  scenarios::kit::SharedPheromone trail_{"trail", {.width_m = 1, .height_m = 1, .cell_m = 0.05, .half_life_s = 5}};
};

struct Member {
  Member(const lab::RunConfig& config, std::uint64_t run_id)
      : runner(config, {{"run.seed", "1"}}, arena, scenario, bus, recorder, run_id) {}
  tests::TemporaryDirectory folder;
  tests::SlowArena arena{false};
  Growing scenario;
  hal::Bus bus{"memq://"};
  hal::Recorder recorder{folder.path(), 0, {.log = false}};
  lab::Runner runner;
  std::unique_ptr<hal::Bus::Subscription> worlds;
};

// Labs a, b, ..., of which a owns. Each has its own clock, and messages take 0 to 300 ms.
class World {
 public:
  explicit World(int labs) {
    for (int i = 0; i < labs; ++i) names_.push_back(std::string(1, static_cast<char>('a' + i)));
    for (const std::string& name : names_) start(name);
  }
  void start(const std::string& name) {
    lab::RunConfig config;
    config.lab = name, config.owner = "a", config.labs = names_;
    for (const std::string& each : names_) config.projections[each];
    config.period = 250ms, config.last_period = 100'000;
    members_.erase(name);
    Member& made = *members_.emplace(name, std::make_unique<Member>(config, ++runs_)).first->second;
    began_[name] = now_ + 30ms * static_cast<std::int64_t>(runs_);
    made.worlds = made.bus.subscribe("world", [this, name](std::string_view, std::span<const std::byte> bytes) {
      bytes_ += bytes.size();
      for (const std::string& to : names_)
        if (to != name && name != cut && to != cut)
          under_way_.push_back({now_ + 1ms * random_.below(300), to, name + "/world", {bytes.begin(), bytes.end()}});
    });
  }
  void pass(std::chrono::seconds time) {
    for (const auto until = now_ + time; now_ < until; now_ += 10ms) {
      for (auto each = under_way_.begin(); each != under_way_.end();) {
        const auto& [when, to, channel, bytes] = *each;
        if (when <= now_) members_.at(to)->bus.publish(channel, bytes);
        each = when <= now_ ? under_way_.erase(each) : std::next(each);
      }
      for (const auto& [name, member] : members_) step(*member, now_ - began_.at(name));
    }
  }
  Member& operator[](const std::string& name) { return *members_.at(name); }
  // How many periods of the owner all labs have seen, from `first` on; all of them alike.
  int alike(std::uint32_t first = 0) {
    int n = 0;
    for (const auto& [period, seen] : (*this)["a"].scenario.seen) {
      const bool of_all = std::ranges::all_of(
          members_, [period = period](const auto& each) { return each.second->scenario.seen.contains(period); });
      if (period < first || !of_all) continue;
      ++n;
      for (const auto& [name, member] : members_) REQUIRE(member->scenario.seen.at(period) == seen);
    }
    return n;
  }
  std::size_t bytes() const { return bytes_; }
  std::string cut;  // nothing from it or to it arrives

 private:
  // An arena that keeps real time.
  void step(Member& member, std::chrono::microseconds local) {
    do member.arena.late = member.arena.clock().now() >= local ? 1'000'000 : 0;
    while (member.runner.step(now_) == lab::Runner::Step::advanced);
  }

  struct UnderWay {
    std::chrono::microseconds when;
    std::string to, channel;
    std::vector<std::byte> bytes;
  };
  hal::RandomStream random_{1, "test/growth"};
  std::chrono::microseconds now_{0};
  std::uint64_t runs_ = 0;
  std::size_t bytes_ = 0;
  std::vector<std::string> names_;
  std::map<std::string, std::chrono::microseconds> began_;
  std::map<std::string, std::unique_ptr<Member>> members_;
  std::deque<UnderWay> under_way_;
};

}  // namespace

TEST_CASE("free labs hold the same stock and trail after the same period, after a cut and after a restart") {
  for (const int labs : {2, 3}) {
    CAPTURE(labs);
    World world(labs);
    world.pass(20s);
    CHECK(world.alike() > 20);
    // They merge different states, so that each by itself would hold something else.
    CHECK(world["b"].runner.drops()["gate.late.a"] > 0);
    world.cut = "b";
    world.pass(10s);
    CHECK(world["b"].runner.state_text().find("growing fields are frozen without a since its period ") !=
          std::string::npos);
    CHECK(world["b"].runner.drops()["growth.frozen"] > 0);
    world.cut.clear();
    const std::uint32_t then = world["a"].runner.period();
    world.pass(10s);
    CHECK(world.alike(then) > 10);
    CHECK(world["b"].runner.state_text().find("stands still") == std::string::npos);
    world.start("b");
    const std::uint32_t later = world["a"].runner.period();
    world.pass(10s);
    CHECK(world.alike(later) > 10);
  }
}

TEST_CASE("a restarted owner has forgotten what grew, and the others say so and keep it") {
  World world(2);
  world.pass(10s);
  world.start("a");
  world.pass(1s);  // what was under way is there
  const auto before = world["b"].scenario.seen.rbegin()->second;
  world.pass(20s);
  CHECK(world["b"].scenario.seen.rbegin()->second == before);
  CHECK(world["b"].runner.state_text().find("growing fields are frozen without a since its period ") !=
        std::string::npos);
  CHECK(world["b"].runner.state_text().find(", which was restarted and has lost them: start all labs again") !=
        std::string::npos);
}
