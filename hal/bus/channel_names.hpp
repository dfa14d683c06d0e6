// The names of a lab's channels, and what a lab may be called.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace arkmesh::hal {

// Channel names on a lab's bus. What lab `roark` exports as `world` is `roark/world` elsewhere.
namespace channel {
inline const std::string poses = "poses", to_robots = "to_robots", from_robots = "from_robots",
                         fleet_command = "fleet_command", arena = "arena", world = "world", status = "status",
                         shared = "shared", peers = "peers", overlay = "overlay", shown = "shown",
                         robot_texts = "robot_texts";
}
inline constexpr std::size_t max_lab_name = 15;  // LCM allows 63 bytes a channel: lab + '/' + channel
inline constexpr std::size_t max_channel_name = 47;
// [a-z0-9_-]{1,15}
bool is_lab_name(std::string_view name);

}  // namespace arkmesh::hal
