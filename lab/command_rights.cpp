#include "lab/command_rights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "hal/messages.hpp"
#include "lab/operator_message.hpp"

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr CommandRights::Now read_again_after = 100ms;  // another key may be there by then

}  // namespace

CommandRights::CommandRights(std::string lab, std::uint64_t run_id, OperatorKey key)
    : lab_(std::move(lab)), run_id_(static_cast<std::int64_t>(run_id)), key_(std::move(key)) {}

std::optional<Refusal> CommandRights::refusal(const operator_command_t& message, Now now) {
  if (message.lab != lab_) return Refusal{"other_lab", "it is for another lab"};
  if (message.run_id != run_id_) return Refusal{"other_run", "it was given to another run of this lab"};
  if (auto refusal = unproved(message, now)) return refusal;
  if (message.number <= newest_) return Refusal{"replayed", "it, or a newer one, was given before"};
  if (message.number > newest_ + number_window) return Refusal{"number", "its number is too large"};
  if (message.command.command != operator_command_t::stop && !hal::from_message(message.command))
    return Refusal{"unknown", "it is no command that this version knows"};
  newest_ = message.number;
  return {};
}

// Without a key that fits, the file is read again: it is made at first need, and may be made anew.
std::optional<Refusal> CommandRights::unproved(const operator_command_t& message, Now now) {
  const std::vector<std::uint8_t> bytes = proved_bytes(message);
  const std::span<const std::uint8_t> all(message.proof), proof = all.first(OperatorKey::proof_bytes),
                                                          rest = all.subspan(OperatorKey::proof_bytes);
  const auto good = [&] {
    return key_.proves(bytes, proof) && std::all_of(rest.begin(), rest.end(), [](auto byte) { return byte == 0; });
  };
  if (good()) return {};
  if (!read_ || now - *read_ >= read_again_after) {
    read_ = now;
    no_key_.clear();
    try {
      key_.read();
    } catch (const std::exception& error) {
      no_key_ = error.what();
    }
    if (no_key_.empty() && good()) return {};
  }
  if (!no_key_.empty()) return Refusal{"no_key", no_key_};
  return Refusal{"bad_proof", fmt::format("it does not prove that this user gave it, by {}", key_.file().string())};
}

}  // namespace arkmesh::lab
