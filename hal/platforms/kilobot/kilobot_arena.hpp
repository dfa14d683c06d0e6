// A testbed of real Kilobots as an arena: cameras see them, an overhead controller talks to them. Cannot wait: lab time
// is real time.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "hal/arena.hpp"
#include "hal/config.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"
#include "hal/platforms/kilobot/overhead_controller.hpp"
#include "hal/platforms/kilobot/robot_monitor.hpp"
#include "hal/platforms/kilobot/stand_guard.hpp"
#include "hal/wall_time.hpp"

namespace arkmesh::hal::kilobot {

struct ArenaSettings {
  ArenaInfo info;
  std::string port;  // a device or tcp://host:port; empty when the arena gets a byte stream of somebody else's
  std::chrono::microseconds names_within{120'000'000};  // how long the beginning may take
  std::size_t may_miss = 0;                             // how many robots may be missing then
  OverheadSettings overhead{.again_after = std::chrono::microseconds{100'000}};
  std::vector<std::string> ids;  // as they are written; in `info` as robot_ids.hpp reads them
  bool has_port = true;          // the port is required

  void fields(const Section& kilobot);
  void check(const Section& kilobot) const { overhead.check(kilobot); }
};

// Reads the common [arena] keys (see arena_config.hpp; `pace` has no effect) and of [arena.kilobot] those above and
// `ids` (see robot_ids.hpp); `port` is required, or not used when there is none. Throws ConfigError.
ArenaSettings read_arena_settings(const Section& arena, const std::string& lab, bool has_port = true);

// The device named: one that is not there now is a mistake in the file or in the arena, later it is a fault that heals.
// `lab` is named to others who want it. Throws PortError.
std::unique_ptr<ByteStream> open_byte_stream(const std::string& port, const std::string& lab);

// advance_to(0) is there when the overhead controller listens and every robot has been seen and named, and throws
// std::runtime_error with what is missing when that takes longer than names_within. Robots that may be missing are
// counted then as `robots.missing_at_start` and looked for on the way. Afterwards it never throws: a camera or a
// controller that is gone costs frames or messages, which are counted, until it is back. Destroying it before end() was
// true waits until it is. Counts `poses.lost.no_picture`, `poses.refused.unknown_robot`, `poses.refused.outside`, what
// OverheadController counts, and what `eyes` counts. `wall`, when it is not the machine's, outlives the arena.
std::unique_ptr<Arena> make_kilobot_arena(ArenaSettings settings, std::unique_ptr<RobotMonitor> eyes,
                                          std::unique_ptr<ByteStream> stream,
                                          std::unique_ptr<StandGuard> guard = nullptr, WallTime& wall = machine_time());

}  // namespace arkmesh::hal::kilobot
