// The physical arena as a lab's file configures it, down to a serial device.
#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <vector>

#include "hal/arenas/robot_words.hpp"
#include "hal/platforms/kilobot/kilobot_arena.hpp"
#include "hal/platforms/kilobot/robot_ids.hpp"
#include "tests/hal/platforms/kilobot/overhead_bench.hpp"
#include "tests/support/kilobot/fake_monitor.hpp"
#include "tests/support/processes/pseudo_terminal.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

namespace {

hal::Section section(const std::string& keys) {
  return hal::Config::from_text("[arena]\nrobots = 4\n" + keys, "lab.toml").root().section("arena");
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("kilobot arena: through a serial device") {
  // The whole way in real time: a configured port, real serial code, packets at the other end, a stop when the arena
  // ends.
  PseudoTerminal terminal;
  const std::string keys = "kilobot.settle_s = 0\nkilobot.port = \"" + terminal.port() + "\"";
  auto eyes_see = std::make_shared<FakeTestbed>();
  eyes_see->robots = {0, 1, 2, 3};
  std::unique_ptr<hal::Arena> arena;
  // libserialport throws away what the terminal holds when it opens
  const ArenaSettings settings = read_arena_settings(section(keys), "roark");
  arena = make_kilobot_arena(settings, std::make_unique<FakeMonitor>(eyes_see), open_byte_stream(settings.port, "lab"));
  hal::advance(*arena, 0us);
  for (int n = 1; n <= 12; ++n) {  // the arena tells the robots to stand first, for 0.5 s
    std::vector<hal::ToRobot> messages;
    for (hal::RobotId robot = 0; robot < 4; ++robot) messages.push_back({robot, 0, 2, static_cast<std::uint16_t>(n)});
    arena->robots().offer(messages);
    hal::advance(*arena, n * 100ms);
  }
  const hal::Airtime airtime = arena->robots().airtime();
  arena.reset();
  PacketEar ear;
  const auto heard = ear.hear(terminal.read());
  REQUIRE(heard.size() >= 4);
  CHECK(heard.front()[1] == static_cast<std::uint8_t>(PacketType::stop));
  CHECK(heard.back()[1] == static_cast<std::uint8_t>(PacketType::stop));
  std::uint64_t blocks = 0;
  for (const Packet& packet : heard) blocks += robots_of(packet).size();
  CHECK(blocks == airtime.sent);
  CHECK(airtime.sent > 4);
}

TEST_CASE("kilobot arena: configuration") {
  // A port that is missing and ids that cannot be are refused with file, line and key, a port that is not there by
  // name.
  const auto error = [](const std::string& keys) -> std::string {
    try {
      const ArenaSettings settings = read_arena_settings(section(keys), "roark");
      make_kilobot_arena(settings, std::make_unique<FakeMonitor>(std::make_shared<FakeTestbed>()),
                         open_byte_stream(settings.port, "lab"));
    } catch (const std::runtime_error& why) {
      return why.what();
    }
    return "";
  };
  CHECK(holds(error(""), "port"));
  CHECK(holds(error("kilobot.port = \"/dev/ttyNONE7\""), "there is no serial port /dev/ttyNONE7"));
  CHECK(holds(error("kilobot.port = \"tcp://here\""), "such as tcp://192.168.1.20:3001"));
  const PseudoTerminal terminal;
  const std::string port = "kilobot.port = \"" + terminal.port() + "\"\n";
  CHECK(error(port).empty());
  CHECK(holds(error(port + "kilobot.ids = [\"0-4\"]"), "lists 5 robots, but arena.robots is 4"));
  CHECK(holds(error(port + "kilobot.ids = [\"1\", \"x\"]"), "\"x\" is neither an id nor a range"));
  CHECK(holds(error(port + "kilobot.ids = [\"5-3\"]"), "\"5-3\" is neither"));
  CHECK(holds(error(port + "kilobot.ids = [\"0-1\", \"1-2\"]"), "robot 1 is listed twice"));
  CHECK(holds(error(port + "kilobot.ids = [\"1020-1023\"]"), "1023 is above 1022"));
  CHECK(holds(error(port + "kilobot.ids = [\"0-4294967295\"]"), "is above 1022"));
  CHECK(holds(error(port + "kilobot.spacing_s = 0.04"), "at least 0.05"));
  CHECK(holds(error(port + "kilobot.names_within_s = 0"), "names_within_s"));

  CHECK(holds(error(port + "kilobot.layout = \"8+16\"\nkilobot.ids = [\"250-255\"]"),
              "255 is above 254, the largest id in the layout 8+16"));

  CHECK(read_robot_ids(section("kilobot.ids = [\"40\", \"3-5\"]"), ark_layout) ==
        std::vector<hal::RobotId>{3, 4, 5, 40});
}

TEST_CASE("kilobot arena: ids in words") {
  // Runs of three and more are written as ranges, long lists end with a count.
  CHECK(hal::in_words(std::vector<hal::RobotId>{}) == "");
  CHECK(hal::in_words({4, 7, 8, 9, 11, 12}) == "4, 7-9, 11, 12");
  CHECK(hal::in_words({1, 3, 5, 7}, 2) == "1, 3 and 2 more");
}
