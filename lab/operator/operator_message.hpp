// Commands of operators as messages: on which channel, and what their proof is about.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "arkmesh/operator_command_t.hpp"

namespace arkmesh::lab {

// On the lab's public bus.
inline const std::string operator_channel = "operator_command";
// How far the number of a command may be above the newest one. Who gives one takes any of them by chance, so that two
// operators do not take the same.
inline constexpr std::int64_t number_window = 1000;

// The bytes that its proof is made of.
std::vector<std::uint8_t> proved_bytes(operator_command_t message);

}  // namespace arkmesh::lab
