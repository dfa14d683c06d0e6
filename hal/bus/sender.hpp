// Who sent a message of a shared bus, which may be anything: reads no more of it than that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace arkmesh::hal {

struct Sender {
  std::string lab;
  std::uint64_t number = 0;  // the field behind the name: a gateway's boot id, or a lab's run id
};

// Of a message of the type with this fingerprint, which begins with a lab's name and a 64-bit number as lab_status_t,
// peers_t and world_t do. Empty when it is none, also one of another version.
std::optional<Sender> read_sender(std::span<const std::byte> bytes, std::int64_t fingerprint);

}  // namespace arkmesh::hal
