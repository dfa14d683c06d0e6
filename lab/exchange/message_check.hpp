// Checks the bytes of a message that came from another lab, from an operator or from the gateway, before it is decoded
// (hal/message_walker).
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace arkmesh::lab {

// Each returns an empty text when the bytes are exactly one well-formed message of that type, else the reason in one
// word
// ("fingerprint", "truncated", "count", "text", "trailing"), fit for a counter's name.
std::string_view check_world(std::span<const std::byte> bytes);
std::string_view check_status(std::span<const std::byte> bytes);
std::string_view check_peers(std::span<const std::byte> bytes);
std::string_view check_operator_command(std::span<const std::byte> bytes);

}  // namespace arkmesh::lab
