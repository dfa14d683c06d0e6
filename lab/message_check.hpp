// Walks the bytes of a message that came from outside and checks every count in it, nested ones too, against the bytes
// that are left. LCM's generated decoders trust counts, so nothing from outside is decoded before this has passed.
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
