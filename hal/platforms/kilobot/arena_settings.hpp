// The keys of [arena.kilobot], read together with the common ones of [arena].
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/config/config.hpp"
#include "hal/platforms/kilobot/overhead_controller.hpp"

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

}  // namespace arkmesh::hal::kilobot
