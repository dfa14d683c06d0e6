#include "lab/operator/command_rights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "hal/arenas/messages.hpp"
#include "hal/label.hpp"
#include "lab/operator/operator_message.hpp"

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr CommandRights::Now read_again_after = 100ms;  // another key may be there by then
constexpr CommandRights::Now too_old_after = 30s;
constexpr int looks_per_s = 50;  // at signatures, 0.1 ms each, whoever sends them

bool is_for_lab(int command) {
  return command >= operator_command_t::disarm && command <= operator_command_t::stop;
}

std::optional<Refusal> unknown(const fleet_command_t& given) {
  if (is_for_lab(given.command) || hal::from_message(given)) return {};
  return Refusal{"unknown", "this version does not know the command"};
}

}  // namespace

CommandRights::CommandRights(const RunConfig& config, std::uint64_t run_id)
    : lab_(config.lab),
      run_id_(static_cast<std::int64_t>(run_id)),
      gap_(static_cast<Now::rep>(1e6 / config.safety.commands_per_s)),
      key_(config.operator_key) {
  givers_[""];
  for (const std::string& peer : config.safety.commands_from) givers_[peer];
}

std::optional<Refusal> CommandRights::refusal(const std::string& peer, const operator_command_t& message, Now now) {
  if (auto refusal = peer.empty() ? unproved(message, now) : forbidden(peer, message, now)) return refusal;
  Giver& giver = givers_.find(peer)->second;
  if (auto refusal = unfit(giver, message, now)) return refusal;
  if (!peer.empty())
    if (auto refusal = unsigned_by(peer, message, now)) return refusal;
  if (auto refusal = admit(peer, giver, message.command, now)) return refusal;
  std::erase_if(giver.used, [now](const auto& one) { return one.second < now - too_old_after; });
  giver.used[message.number] = Now(message.clock_us);
  return {};
}

std::optional<Refusal> CommandRights::refusal_here(const operator_command_t& message, Now now) {
  if (auto refusal = unknown(message.command)) return refusal;
  return admit("", givers_.find("")->second, message.command, now);
}

// What all others have let pass.
std::optional<Refusal> CommandRights::admit(const std::string& peer, Giver& giver, const fleet_command_t& given,
                                            Now now) {
  const int command = given.command;
  if (command == operator_command_t::arm && givers_.size() == 1)
    return Refusal{"no_peers", "no other operator is allowed: safety.commands_from names no lab"};
  if (command == fleet_command_t::run) giver.last_run = now;
  ++giver.admitted;
  // Who makes robots stand still here may be about to reach among them; who makes all labs' robots stand goes on here.
  if (command == operator_command_t::arm)
    armed_ = true;
  else if (is_for_lab(command) || (peer.empty() && given.type != operator_command_t::of_world &&
                                   (command == fleet_command_t::pause || command == fleet_command_t::reset)))
    armed_ = false;
  return {};
}

// A peer whose commands do not count, whatever they are.
std::optional<Refusal> CommandRights::forbidden(const std::string& peer, const operator_command_t& message,
                                                Now now) const {
  const auto giver = givers_.find(peer);
  if (giver == givers_.end())
    return Refusal{"no_permission",
                   fmt::format("safety.commands_from does not name {}", hal::printable(peer, hal::max_lab_name))};
  const auto word = std::ranges::find(operator_words, message.command.command, &OperatorWord::command);
  if (word == std::end(operator_words) || !word->at_others)
    return Refusal{"not_for_peers", "other labs may only pause and resume robots, and end the run"};
  if (word->makes_stand) return {};  // who makes robots stand need not wait for anybody
  if (!armed_)
    return Refusal{"not_armed",
                   fmt::format("{} is not armed, so other labs' operators may not resume its robots", lab_)};
  if (giver->second.last_run && now - *giver->second.last_run < gap_)
    return Refusal{"too_often", fmt::format("{} has resumed more often than safety.commands_per_s allows", peer)};
  return {};
}

// What was not made for this moment.
std::optional<Refusal> CommandRights::unfit(const Giver& giver, const operator_command_t& message, Now now) const {
  if (message.run_id != run_id_) return Refusal{"other_run", "it was sent to another run of this lab"};
  if (Now(message.clock_us) > now || Now(message.clock_us) < now - too_old_after)
    return Refusal{"too_old", "it is more than 30 s old"};
  if (giver.used.contains(message.number)) return Refusal{"replayed", "it was received before"};
  return unknown(message.command);
}

// Without a key that fits, the file is read again: it is made at first need, and may be made anew.
std::optional<Refusal> CommandRights::unproved(const operator_command_t& message, Now now) {
  const auto good = [&] { return key_.proves(proved_bytes(message), message.proof); };
  if (good()) return {};
  if (now - read_ >= read_again_after) {
    read_ = now;
    no_key_.clear();
    try {
      key_.read();
    } catch (const std::exception& error) {
      no_key_ = error.what();
    }
    if (good()) return {};
  }
  if (!no_key_.empty()) return Refusal{"no_key", no_key_};
  return Refusal{"bad_proof", fmt::format("it is not authenticated with this user's key, {}", key_.file().string())};
}

std::optional<Refusal> CommandRights::unsigned_by(const std::string& peer, const operator_command_t& message, Now now) {
  if (now - looks_begun_ >= 1s) looks_begun_ = now, looks_ = 0;
  if (++looks_ > looks_per_s) return Refusal{"too_often", "too many signatures to check"};
  if (has_signed_ && has_signed_(peer, proved_bytes(message), message.proof)) return {};
  return Refusal{"bad_proof",
                 fmt::format("it is not signed by {}, or {} is not trusted (arkmesh keys list)", peer, peer)};
}

hal::Counters CommandRights::counters() const {
  hal::Counters all;
  if (givers_.size() > 1) all.set("operator.armed", armed_ ? 1 : 0);
  for (const auto& [peer, giver] : givers_)
    if (giver.admitted > 0) all.set("operator.commands" + (peer.empty() ? "" : "." + peer), giver.admitted);
  return all;
}

}  // namespace arkmesh::lab
