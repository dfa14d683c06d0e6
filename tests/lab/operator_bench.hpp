// Commands of operators as a test gives them.
#pragma once

#include <algorithm>
#include <string>

#include "arkmesh/fleet_command_t.hpp"
#include "hal/arenas/messages.hpp"
#include "lab/operator/operator_key.hpp"
#include "lab/operator/operator_message.hpp"

namespace arkmesh::tests {

// The next command for a run of lab "a", with its proof.
inline operator_command_t command_for_a(const lab::OperatorKey& key, std::uint8_t command, std::int64_t number,
                                        std::int64_t run_id = 5, std::int64_t clock_us = 0) {
  operator_command_t message{};
  message.lab = "a";
  message.run_id = run_id;
  message.number = number;
  message.clock_us = clock_us;
  message.command.command = command;
  std::ranges::copy(key.prove(lab::proved_bytes(message)).value(), message.proof);
  return message;
}

inline std::vector<std::byte> encoded(const operator_command_t& message) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

// Peers whose signature is a byte of theirs, 64 times.
inline bool has_signed(const std::string& peer, std::span<const std::uint8_t>,
                       std::span<const std::uint8_t> signature) {
  return std::ranges::all_of(signature, [&](std::uint8_t byte) { return byte == peer[0]; });
}

// As lab `peer` gives it.
inline operator_command_t command_of(const std::string& peer, std::uint8_t command, std::int64_t number) {
  operator_command_t message{};
  message.lab = "a";
  message.run_id = 5;
  message.number = number;
  message.command.command = command;
  std::ranges::fill(message.proof, static_cast<std::uint8_t>(peer[0]));
  return message;
}

}  // namespace arkmesh::tests
