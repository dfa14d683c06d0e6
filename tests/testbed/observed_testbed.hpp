// A small testbed of Kilobots on an emulated testbed, seen and spoken to by the physical arena, with the truth beside
// it.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "emulator/emulated_arena.hpp"
#include "emulator/emulator_record.hpp"
#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::tests {

class ObservedTestbed {
 public:
  static constexpr int robots = 8;

  // `more`: keys of the camera, tables of the emulator, that are as they are since the calibration was made, and
  // [[emulator.event]]s, whose times count from when the cameras were switched on.
  explicit ObservedTestbed(const std::string& more = "", std::uint64_t seed = 1, int count = robots,
                           const std::string& controller = "scenarios/dhtf/controller/dhtf.c") {
    const auto emulator_file = directory_.path() / "emulator.toml", calibration = directory_.path() / "testbed.yaml";
    const std::string text =
        "[arena]\nrobots = " + std::to_string(count) +
        "\nwidth_m = 0.5\nheight_m = 0.5\n"
        "[arena.ode]\ncontroller = \"" ARKMESH_SOURCE_DIR "/" +
        controller +
        "\"\n"
        "[[emulator.camera]]\nname = \"camera0\"\nwidth_px = 640\nheight_px = 480\nz_m = 0.95\nfocal_px = 800.0\n";
    std::ofstream(emulator_file) << text << more;
    const hal::Config emulator = hal::Config::from_text(text, "emulator.toml");
    emulator::write_calibration(emulator::Emulator(emulator.root()), calibration);
    const hal::Config config =
        hal::Config::from_text(fmt::format("[arena]\nrobots = {}\nwidth_m = 0.5\nheight_m = 0.5\nemulated.file = "
                                           "\"{}\"\n[[arena.kilobot.cameras]]\nsource = \"0\"\ncalibration = \"{}\"\n",
                                           count, emulator_file.string(), calibration.string()),
                               "testbed.toml");
    arena = emulator::make_emulated_arena(config.root().section("arena"), "lab", seed, {});
    this->emulator().listen([this](const sim_ode::Transmission& sent) { hear(sent); });
  }

  // Its last words are nobody's business.
  ~ObservedTestbed() { emulator().listen({}); }
  ObservedTestbed(const ObservedTestbed&) = delete;
  ObservedTestbed& operator=(const ObservedTestbed&) = delete;

  emulator::Emulator& emulator() { return emulator::emulator_of(*arena); }
  void happen(const std::string& command) {
    const std::string answer = emulator().command(command);
    if (answer != "ok") throw std::runtime_error(fmt::format("{}: {}", command, answer));
  }

  // Until everybody is named, and on the way with all robots walking.
  void start() {
    hal::advance(*arena, hal::LabTime{0});
    frame = arena->poses().latest();
    arena->robots().command({hal::FleetCommand::Kind::run});
  }

  // One more frame, if there was one to be made; says something to every robot, as scenarios do.
  void step() {
    now_ += arena->info().frame_period;
    hal::advance(*arena, now_);
    frame = arena->poses().latest();
    note_frame();
    std::vector<hal::ToRobot> said;
    for (const hal::RobotId robot : arena->info().robots)
      said.push_back({robot, 0, 0, static_cast<std::uint16_t>(++words_ % 256)});
    arena->robots().offer(said);
  }
  void steps(
      double seconds, const std::function<void()>& each = [] {}) {
    for (int n = 0; n < std::lround(seconds * 10); ++n) step(), each();
  }
  hal::LabTime now() const { return now_; }
  // Messages on the air to robots that no frame had named for longer than the controller needs to hear of it and to end
  // what it is saying.
  int said_blindly() const { return said_blindly_; }
  // The last message on the air to that robot began then, in the emulated testbed's time.
  hal::LabTime last_said(hal::RobotId id) const {
    return last_said_.contains(id) ? last_said_.at(id) : hal::LabTime{-1};
  }
  std::uint64_t counted(std::string_view name) const { return arena->counters()[name]; }

  // Where the robot with that id is in truth; nothing while it is off the arena.
  std::optional<hal::Pose> truth(hal::RobotId id) {
    for (const auto& each : emulator().truth())
      if (each.id == id && each.seen.in_arena) return each.seen.pose;
    return {};
  }
  // Whether the frame says where that robot is, and that is where it is; and whether it says something that is wrong.
  bool right(hal::RobotId id) {
    return says(id, [](double off_m, const hal::Observation& seen) {
      return off_m < 0.01 && seen.age < hal::LabTime{500'000};
    });
  }
  bool wrong(hal::RobotId id) {
    // An observation with an age says where the robot was, and is no lie.
    return says(id,
                [](double off_m, const hal::Observation& seen) { return off_m > 0.01 && seen.age == hal::LabTime{0}; });
  }
  int right() {
    return static_cast<int>(std::ranges::count_if(arena->info().robots, [&](hal::RobotId id) { return right(id); }));
  }
  int wrong() {
    return static_cast<int>(std::ranges::count_if(arena->info().robots, [&](hal::RobotId id) { return wrong(id); }));
  }

  std::unique_ptr<hal::Arena> arena;
  std::optional<hal::PoseFrame> frame;

 private:
  template <class Verdict>
  bool says(hal::RobotId id, Verdict verdict) {
    if (!frame) return false;
    for (const hal::Observation& seen : frame->robots) {
      if (seen.robot != id) continue;
      const auto at = truth(id);
      const double off_m = at ? std::hypot(at->x_m - seen.pose.x_m, at->y_m - seen.pose.y_m) : 1;
      return verdict(off_m, seen);
    }
    return false;
  }

  void note_frame() {
    for (const hal::RobotId id : arena->info().robots) {
      const bool named = frame && std::ranges::any_of(frame->robots, [id](const hal::Observation& seen) {
                           return seen.robot == id && seen.age == hal::LabTime{0};
                         });
      if (named)
        nameless_since_.erase(id);
      else
        nameless_since_.try_emplace(id, emulator().now());
    }
  }
  // The emulator's time runs ahead of what it tells of.
  void hear(const sim_ode::Transmission& sent) {
    if (sent.message.type != 0) return;
    for (std::size_t at = 0; at < sent.message.data.size(); at += 3) {
      const auto id = static_cast<hal::RobotId>(sent.message.data[at] << 2 | sent.message.data[at + 1] >> 6);
      if (id == 1023) continue;
      last_said_[id] = hal::LabTime{sent.start_us};
      const auto since = nameless_since_.find(id);
      if (since != nameless_since_.end() && sent.start_us - since->second.count() > packet_us) ++said_blindly_;
    }
  }

  static constexpr std::int64_t packet_us = 60'000;  // 132 bytes on the line, and the message that they interrupt
  TemporaryDirectory directory_;
  std::map<hal::RobotId, hal::LabTime> nameless_since_, last_said_;
  int said_blindly_ = 0;
  hal::LabTime now_{0};
  std::uint64_t words_ = 0;
};

}  // namespace arkmesh::tests
