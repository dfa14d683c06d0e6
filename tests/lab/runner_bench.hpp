// A runner with an arena and a scenario that only note what they are asked.
#pragma once

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <chrono>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "hal/arenas/newest_frame.hpp"
#include "lab/runner.hpp"
#include "tests/lab/operator_bench.hpp"
#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::tests {

using namespace std::chrono_literals;

class NotingLink final : public hal::RobotLink {
 public:
  void offer(std::span<const hal::ToRobot> newest) override {
    offered.insert(offered.end(), newest.begin(), newest.end());
  }
  hal::Airtime airtime() const override { return {.offered = offered.size()}; }
  void command(const hal::FleetCommand& command) override {
    commands.push_back(command.kind);
    if (command.kind == hal::FleetCommand::Kind::broadcast) broadcasts.push_back({command.type, command.data});
  }
  hal::NotHeard not_heard() override {
    return std::exchange(lost, {.openings = lost.openings, .broadcasts{}, .words{}, .restarted{}});
  }
  std::vector<hal::FromRobot> heard() override { return std::exchange(to_hear, {}); }
  std::vector<hal::ToRobot> offered;
  std::vector<hal::FleetCommand::Kind> commands;
  std::vector<hal::WholeMessage> broadcasts;
  std::vector<hal::FromRobot> to_hear;
  hal::NotHeard lost;
};

// A frame each 100 ms with odd numbers in it; not there yet for the next `late` calls.
class SlowArena final : public hal::Arena {
 public:
  explicit SlowArena(bool can_wait = true) {
    using Kind = hal::FleetCommand::Kind;
    info_.robots = {1}, info_.max_robot = 9, info_.can_wait = can_wait;
    info_.commands = {Kind::run, Kind::pause, Kind::reset, Kind::sleep, Kind::broadcast};
  }
  const hal::ArenaInfo& info() const override { return info_; }
  void start_with_labs() { info_.starts_with_labs = true; }
  const hal::Clock& clock() const override { return clock_; }
  hal::PoseSource& poses() override { return frames_; }
  NotingLink& robots() override { return link_; }
  bool advance_to(hal::LabTime t) override {
    if (late > 0) return --late, false;
    asked.push_back(t);
    if (t >= fail_at) throw std::runtime_error("the arena fails");
    clock_.set(t);
    if (t % info_.frame_period == hal::LabTime{0})
      frames_.put({.stamp = t,
                   .number = static_cast<std::uint32_t>(t / info_.frame_period),
                   .robots = {{.robot = 1, .pose = {0.1 / 3, -1e-300, 3.14159}, .confidence = 0.3f}}});
    return true;
  }
  void serve() override {
    ++served;
    if (gone) throw std::runtime_error("the arena is gone");
  }
  hal::TimePoint next_service() const override { return late > 0 ? hal::TimePoint::max() : hal::TimePoint::min(); }
  std::string waiting_for() const override { return late > 0 && says ? "two robots" : ""; }
  bool end() override { return ++ends > ends_after; }
  std::vector<hal::NotStanding> not_standing() const override { return seen_to_walk; }
  const hal::Counters& counters() const override { return counters_; }
  void count(const char* name) { counters_.add(name); }

  int late = 0, served = 0, ends = 0, ends_after = 0;
  std::vector<hal::NotStanding> seen_to_walk;
  bool says = false, gone = false;
  hal::LabTime fail_at = hal::LabTime::max();
  std::vector<hal::LabTime> asked;

 private:
  hal::Counters counters_;
  hal::ArenaInfo info_;
  hal::OwnedClock clock_;
  hal::NewestFrame frames_{counters_};
  NotingLink link_;
};

// Notes each call, says something in each, and writes rows.
class NotingScenario final : public lab::Scenario {
 public:
  void begin(lab::Lab& lab) override {
    calls.push_back("begin");
    lab.row("table", "what", "begin");
    lab.declare({.name = "team", .length = 1, .low = 0, .high = 5});
  }
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override {
    calls.push_back(fmt::format("poses {}", frame.number));
    newest = frame;
    lab.say({.robot = 1, .kind = 1});
    if (frame.number == tells_at) lab.tell({.robot = 1, .slot = 5, .kind = 7}, true);
    lab.row("table", "what", fmt::format("poses {}", frame.number));
    if (frame.number == fail_at) throw std::runtime_error("the scenario fails");
  }
  void on_heard(lab::Lab& lab, std::span<const hal::FromRobot> messages) override {
    calls.push_back(fmt::format("heard {} of {}", messages.size(), messages[0].robot));
    lab.say({.robot = 1, .kind = 2});
  }
  void on_period(lab::Lab& lab) override {
    calls.push_back(fmt::format("period {}", lab.period()));
    for (const auto& [field, values] : publishes) lab.publish(field, values);
  }
  bool settled(lab::Lab& lab, std::chrono::milliseconds) override {
    if (unsettled > 0) return --unsettled, false;
    unsettled = computes;
    if (computes > 0 && calls.back().starts_with("poses")) lab.say({.robot = 1, .kind = 3});
    return true;
  }
  bool finished(const lab::Lab& lab) const override { return lab.period() == end_at; }
  int computes = 0, unsettled = 0;  // it is asked so often before it has settled; how often that is still to come
  std::vector<std::string> calls;
  hal::PoseFrame newest;
  std::uint32_t end_at = 1000, fail_at = 1000;                 // a period, and a frame
  std::uint32_t tells_at = 1000;                               // a frame at which it tells kind 7, once
  std::map<std::string, std::vector<std::int64_t>> publishes;  // at each boundary, for the next state
};

inline lab::RunConfig config_of_one_lab() {
  lab::RunConfig c;
  c.lab = c.owner = "a";
  c.labs = {"a"};
  c.projections["a"];
  c.period = 250ms;
  c.last_period = 2;
  return c;
}

struct Bench {
  explicit Bench(lab::RunConfig run = config_of_one_lab(), bool can_wait = true)
      : config(std::move(run)), arena(can_wait) {}

  lab::RunConfig config;
  TemporaryDirectory folder;
  lab::OperatorKey key{config.operator_key = folder.path() / "operator.key"};
  SlowArena arena;
  NotingScenario scenario;
  hal::Bus bus{"memq://"};
  hal::Recorder recorder{folder.path(), 0, {.log = false}};
  std::vector<std::string> channels;
  lab::Runner runner{config, {{"run.seed", "1"}}, arena, scenario, bus, recorder, 5};
  std::unique_ptr<hal::Bus::Subscription> all = bus.subscribe(".*", [this](std::string_view channel, auto) {
    if (channel != "status" && channel != "world" && channel != "shared") channels.emplace_back(channel);
  });
  std::string state_heard;
  std::unique_ptr<hal::Bus::Subscription> states = bus.subscribe("status", [this](std::string_view, auto bytes) {
    lab_status_t status;
    REQUIRE(hal::decode(bytes, status));
    state_heard = status.state;
  });
  std::chrono::microseconds now{0};
  std::int64_t told = 0;  // commands

  // The lab's operator does.
  void tell(std::uint8_t command) {
    key.make(), key.read();
    runner.hear_command(lab::operator_channel, encoded(command_for_a(key, command, ++told, 5, runner.now().count())));
  }
  lab::Runner::Step step() { return runner.step(now += 1ms); }
  void run() {
    while (step() != lab::Runner::Step::ended) REQUIRE(now < 10s);
  }
};

}  // namespace arkmesh::tests
