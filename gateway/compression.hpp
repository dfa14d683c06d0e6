// One message made shorter, and long again, with zstd. Pure.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace arkmesh::gateway {

// The length of the bytes (4 bytes, big-endian) and a zstd frame; empty when that is not shorter than they are.
std::vector<std::byte> compress(std::span<const std::byte> bytes);
// What was compressed; nothing when it is damaged, or says that it is longer than `max_bytes`. No memory is asked for
// before that was compared, and never more.
std::optional<std::vector<std::byte>> decompress(std::span<const std::byte> packed, std::size_t max_bytes);

}  // namespace arkmesh::gateway
