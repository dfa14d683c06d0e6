// Commands of operators as a test gives them.
#pragma once

#include <algorithm>
#include <string>

#include "arkmesh/fleet_command_t.hpp"
#include "hal/messages.hpp"
#include "lab/operator_key.hpp"
#include "lab/operator_message.hpp"

namespace arkmesh::tests {

// The next command for a run of lab "a", with its proof.
inline operator_command_t command_for_a(const lab::OperatorKey& key, std::uint8_t command, std::int64_t number,
                                        std::int64_t run_id = 5) {
  operator_command_t message{};
  message.lab = "a";
  message.run_id = run_id;
  message.number = number;
  message.command.command = command;
  std::ranges::copy(key.prove(lab::proved_bytes(message)).value(), message.proof);
  return message;
}

inline std::vector<std::byte> encoded(const operator_command_t& message) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace arkmesh::tests
