#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <vector>

#include "hal/arenas/arena_config.hpp"
#include "hal/arenas/solids.hpp"
#include "hal/platforms/aseba/aseba_arena.hpp"
#include "hal/platforms/kilobot/descriptor_stream.hpp"
#include "hal/robot/thymio.hpp"

namespace arkmesh::hal::aseba {
namespace {

// 70 mm across, wheels 53 mm apart, 13 cm/s at its greatest; 128 steps of its motors to 1 cm.
RobotKind e_puck() {
  RobotKind out = thymio();
  out.make = "e-puck";
  out.body_radius_m = 0.037;
  out.height_m = 0.05;
  out.drive = {.way = RobotDrive::Way::differential, .speed_m_s = 0.128, .wheels_apart_m = 0.053};
  out.says.clear();
  return out;
}

struct KnownMake {
  RobotKind kind;
  Make make;
};

const std::vector<KnownMake>& makes() {
  static const std::vector<KnownMake> all{
      {thymio(), {"thymio", {"motor.left.target", "motor.right.target"}, thymio_target_per_mm_s}},
      {e_puck(), {"e-puck", {"speed.left", "speed.right"}, 7.8}},
  };
  return all;
}

const KnownMake& known(const std::string& name) {
  return *std::ranges::find(makes(), name, [](const KnownMake& one) { return one.make.name; });
}

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(' ');
  return first == std::string_view::npos ? std::string()
                                         : std::string(text.substr(first, text.find_last_not_of(' ') - first + 1));
}

}  // namespace

const Make& make_of(const std::string& name) {
  return known(name).make;
}

const RobotKind& kind_of(const std::string& make) {
  return known(make).kind;
}

void AsebaSettings::fields(const Section& aseba) {
  aseba.field(
      "connect", connect,
      {.help = "the Aseba nodes: tcp:HOST:PORT or devices, separated by commas; \"3 = /dev/ttyACM0\" is robot 3",
       .sample = "\"tcp:127.0.0.1:33333\"",
       .required = true});
  std::vector<std::string> names;
  for (const KnownMake& one : makes()) names.push_back(one.make.name);
  aseba.field("robot", make, {.help = "type of the robots", .one_of = names});
  aseba.field("first_id", first_id, {.range = {0, 65'535}, .help = "id of the first robot; the others follow"});
  aseba.field("names_within_s", names_within, {{1, 3600}, "s", "time limit for finding all robots at the start"});
  aseba.field("may_miss", may_miss, {{0, 1023}, "robots", "how many robots may still be missing then"});
  aseba.field("words_per_s", words_per_s, {{1, 10'000}, "1/s", "rate limit of messages, over all robots"});
}

AsebaSettings read_aseba_settings(const Section& arena, const std::string& lab) {
  const Section aseba = arena.section("aseba");
  auto out = aseba.read<AsebaSettings>();
  const RobotKind& kind = kind_of(out.make);
  const ArenaConfig config = read_arena_config(arena, kind.body_radius_m);
  Solids solids = read_solids(arena);
  if (!solids.objects.empty())
    arena.refuse("objects", "cameras do not see objects; remove them, or use a simulated arena");
  if (out.first_id + config.robots > 65'536) aseba.refuse("first_id", "robots' numbers end at 65535");
  ArenaInfo& info = out.info;
  static_cast<RobotKind&>(info) = kind;
  info.values = 1 << 15;  // of a variable that is not negative
  info.words_per_s = out.words_per_s;
  info.name = lab;
  info.platform = "aseba";
  info.width_m = config.width_m;
  info.height_m = config.height_m;
  info.obstacles = std::move(solids.obstacles);
  for (int i = 0; i < config.robots; ++i) info.robots.push_back(static_cast<RobotId>(out.first_id + i));
  info.can_wait = false;
  info.frame_period = config.frame_period;
  return out;
}

std::vector<Connection> open_connections(const Section& aseba, const AsebaSettings& settings) {
  std::vector<Connection> out;
  std::string_view rest = settings.connect;
  while (!rest.empty()) {
    const std::string_view part = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), part.size() + 1));
    Connection connection;
    std::string where = trimmed(part);
    if (const auto equals = where.find('='); equals != std::string::npos) {
      const std::string name = trimmed(std::string_view(where).substr(0, equals));
      RobotId robot = 0;
      const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), robot);
      if (error != std::errc{} || end != name.data() + name.size() ||
          !std::ranges::binary_search(settings.info.robots, robot))
        aseba.refuse("connect", fmt::format("\"{}\" is not one of this arena's robots, which are {} to {}", name,
                                            settings.info.robots.front(), settings.info.robots.back()));
      connection.robot = robot;
      where = trimmed(std::string_view(where).substr(equals + 1));
    }
    connection.name = where;
    try {
      constexpr std::string_view tcp = "tcp:";
      if (where.empty()) throw kilobot::PortError("one of its names is empty");
      if (where.starts_with(tcp)) {
        const bool slashes = where.starts_with("tcp://");
        connection.stream = std::make_unique<kilobot::DescriptorStream>(
            kilobot::tcp_line(where.substr(slashes ? 6 : 4), "is asebaswitch, or the simulator, running?"));
      } else if (where.find(':') != std::string::npos) {
        throw kilobot::PortError(where + ": write tcp:HOST:PORT, or a device such as /dev/ttyACM0");
      } else {
        connection.stream = std::make_unique<kilobot::DescriptorStream>(
            kilobot::serial_line(where.front() == '/' ? where : "/dev/" + where, 115'200));
      }
    } catch (const kilobot::PortError& error) {
      aseba.refuse("connect", error.what());
    }
    out.push_back(std::move(connection));
  }
  if (out.empty()) aseba.refuse("connect", "names no node: write tcp:HOST:PORT, or a device such as /dev/ttyACM0");
  return out;
}

}  // namespace arkmesh::hal::aseba
