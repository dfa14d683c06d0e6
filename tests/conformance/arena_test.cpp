// Every arena runs the same checks. A new platform adds its line to rows().
#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "emulator/emulated_arena.hpp"
#include "emulator/emulator_record.hpp"
#include "hal/arenas/log_arena.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/arenas/null_arena.hpp"
#include "hal/platforms/kilobot/kilobot_arena.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "hal/record/recorder.hpp"
#include "sim_ode/ode_arena.hpp"
#include "tests/conformance/arena_conformance.hpp"
#include "tests/conformance/arena_repeats.hpp"
#include "tests/examples/rover/rover_arena.hpp"
#include "tests/support/aseba/scripted_eyes.hpp"
#include "tests/support/aseba/scripted_node.hpp"
#include "tests/support/kilobot/fake_cable.hpp"
#include "tests/support/kilobot/fake_monitor.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;

namespace {

// The [arena] section of a configuration with these keys.
Section arena_section(const std::string& keys) {
  return Config::from_text("[arena]\nrobots = 6\nwidth_m = 0.6\n" + keys, "conformance.toml").root().section("arena");
}

// Two seconds of robots that walk in circles, as a log.
std::filesystem::path recorded_log() {
  static const TemporaryDirectory directory;
  Recorder recorder(directory.path(), 0, {});
  for (std::uint32_t n = 0; n <= 20; ++n) {
    PoseFrame frame;
    frame.number = n;
    frame.stamp = n * LabTime{100'000};
    for (int i = 0; i < 6; ++i)
      frame.robots.push_back(
          {static_cast<RobotId>(3 * i), {0.2 * std::cos(n + i), 0.2 * std::sin(n + i), 0.1 * i}, Led::cyan, 1, {}});
    for (const pose_frame_t& part : to_messages(frame)) {
      std::vector<std::byte> bytes(static_cast<std::size_t>(part.getEncodedSize()));
      part.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
      recorder.record(frame.stamp, channel::poses, bytes);
    }
  }
  return directory.path() / "log.lcm";
}

// Simulated robots that run the program of the DHTF experiment.
const std::string walkers = "[arena.ode]\ncontroller = \"" ARKMESH_SOURCE_DIR "/scenarios/dhtf/controller/dhtf.c\"\n";

// A platform that knows little: it can be told to run.
const RobotKind plain_robot{.make = "plain",
                            .body_radius_m = 0.05,
                            .drive = {.speed_m_s = 0.1},
                            .max_robot = 9,
                            .kinds = 2,
                            .values = 8,
                            .commands = {FleetCommand::Kind::run}};

// A testbed whose eyes see six robots at once and whose overhead controller takes everything.
std::unique_ptr<Arena> kilobot_testbed() {
  auto table = std::make_shared<FakeTestbed>();
  table->robots = {0, 1, 2, 3, 4, 5};
  return kilobot::make_kilobot_arena(kilobot::read_arena_settings(arena_section("kilobot.settle_s = 0"), "lab", false),
                                     std::make_unique<FakeMonitor>(table),
                                     std::make_unique<FakeStream>(std::make_shared<FakeCable>()));
}

// Robots whose nodes and markers are a test's.
std::unique_ptr<Arena> aseba_robots() {
  const auto settings =
      aseba::read_aseba_settings(arena_section("[arena.aseba]\nconnect = \"tcp:127.0.0.1:1\"\n"), "lab");
  auto line = std::make_shared<ScriptedLine>(machine_time());
  auto sight = std::make_shared<ScriptedSight>();
  for (const RobotId robot : sight->robots = settings.info.robots)
    line->nodes.push_back({.number = static_cast<std::uint16_t>(robot)});
  std::vector<aseba::Connection> connections;
  connections.push_back({"the line", {}, std::make_unique<ScriptedStream>(line)});
  return aseba::make_aseba_arena(settings, std::move(connections), std::make_unique<ScriptedEyes>(sight));
}

// A small testbed on an emulated testbed: its file and its cameras' calibration.
std::string observed_testbed() {
  static const TemporaryDirectory directory;
  const auto emulator_file = directory.path() / "emulator.toml", calibration = directory.path() / "testbed.yaml";
  std::ofstream(emulator_file)
      << "[arena]\nrobots = 6\nwidth_m = 0.6\nheight_m = 0.4\n"
      << walkers
      << "[[emulator.camera]]\nname = \"camera0\"\nwidth_px = 640\nheight_px = 480\nz_m = 1.0\nfocal_px = 800.0\n";
  const Config config = Config::from_file(emulator_file);
  emulator::write_calibration(emulator::Emulator(config.root()), calibration);
  return "height_m = 0.4\nemulated.file = \"" + emulator_file.string() +
         "\"\n[[arena.kilobot.cameras]]\nsource = \"0\"\ncalibration = \"" + calibration.string() + "\"\n";
}

const std::vector<tests::ArenaRow>& rows() {
  static const std::string log = recorded_log().string();
  static const std::string kilobots = observed_testbed();
  static const std::vector<tests::ArenaRow> table{
      {"null",
       [] {
         return make_null_arena(arena_section(""), "lab",
                                kilobot::kind_of(kilobot::ark_layout, WholeMessages::to_nobody));
       }},
      {"paced null",
       [] {
         return make_null_arena(arena_section("pace = 1"), "lab",
                                kilobot::kind_of(kilobot::ark_layout, WholeMessages::to_nobody));
       }},
      {"null of plain robots", [] { return make_null_arena(arena_section(""), "lab", plain_robot); }},
      {"ode", [] { return sim_ode::make_ode_arena(arena_section(walkers), "lab", 1); }, true},
      {"ode of thymios",
       [] { return sim_ode::make_ode_arena(arena_section("[arena.ode]\nrobot = \"thymio\"\n"), "lab", 1); }, true},
      {"paced ode", [] { return sim_ode::make_ode_arena(arena_section("pace = 1\n" + walkers), "lab", 1); }, true},
      {"replay",
       [] {
         return make_log_arena(arena_section("replay.log = \"" + log + "\""), "lab",
                               kilobot::kind_of(kilobot::ark_layout, WholeMessages::to_nobody), LabTime{2'000'000});
       }},
      {"emulated kilobot", [] { return emulator::make_emulated_arena(arena_section(kilobots), "lab", 1, {}); }, false,
       true, [](Arena& arena) { return emulator::emulator_of(arena).now(); }},
      {"kilobot", kilobot_testbed, false, false},
      {"aseba", aseba_robots, false, false},
      {"rover",
       [] { return examples::rover::rover_arena_row().make(arena_section("rover.damage = 0.001"), {.lab = "lab"}); },
       false, false},
  };
  return table;
}

void for_each_arena(void (*check)(const tests::ArenaRow&)) {
  for (const tests::ArenaRow& row : rows()) {
    CAPTURE(row.name);
    check(row);
  }
}

}  // namespace

TEST_CASE("arena: info") {
  // The info of every arena is whole, its robots ascend, its clock begins at 0.
  for_each_arena(check_info);
}

TEST_CASE("arena: frame 0") {
  // Every arena has frame 0 after advance_to(0), once, and robots stand still until a later time.
  for_each_arena(check_frame_zero);
}

TEST_CASE("arena: frames") {
  // Frames of every arena come at multiples of the frame period, numbered, sorted and in range.
  for_each_arena(check_frames);
}

TEST_CASE("arena: latest") {
  // latest() never repeats, never blocks, and gives the newest frame at or before lab time.
  for_each_arena(check_latest);
}

TEST_CASE("arena: limits") {
  // Unknown robots and values outside the info are refused and counted by every arena.
  for_each_arena(check_limits);
}

TEST_CASE("arena: registers") {
  // The newest message of a register wins, and the totals of every arena always add up.
  for_each_arena(check_registers);
}

TEST_CASE("arena: commands") {
  // Every arena takes every command of its platform at any time and refuses the others by name.
  for_each_arena(check_commands);
}

TEST_CASE("arena: what was not heard") {
  // Whoever owns what robots know learns from every arena what did not go out, once.
  for_each_arena(check_not_heard);
}

TEST_CASE("arena: reset") {
  // Where robots run a program, a reset means the same: they begin it again, and wait for run.
  for (const tests::ArenaRow& row : rows())
    if (row.name == "ode" || row.name == "emulated kilobot") {
      CAPTURE(row.name);
      check_reset(row);
    }
}

TEST_CASE("arena: standing") {
  // Every arena comes to know that its robots stand when they were told to, and keeps them standing at the end.
  for_each_arena(check_standing);
}

TEST_CASE("arena: no call blocks") {
  // Whoever runs an arena does the waiting: calls are quick, and what is not there yet says when to ask again.
  for_each_arena(check_waits_for_nobody);
}

TEST_CASE("arena: repeatable") {
  // Arenas repeat themselves bit for bit, however they are served and, if they can wait, however lab time is sliced.
  for_each_arena(check_repeatable);
}

TEST_CASE("arena: pace") {
  // An arena that cannot wait keeps real time.
  for_each_arena(check_pace);
}
