#include "lab/operator/operator_desk.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "hal/arenas/messages.hpp"
#include "hal/bus/bus.hpp"
#include "hal/label.hpp"
#include "lab/operator/operator_message.hpp"

namespace arkmesh::lab {
namespace {

const std::optional<Refusal> ended = Refusal{"ended", "the run has ended"};
constexpr std::ptrdiff_t most_answers = 8;  // to commands that are done, and to others

}  // namespace

OperatorDesk::OperatorDesk(const RunConfig& config, std::uint64_t run_id, hal::Recorder& recorder,
                           const hal::Clock& clock)
    : lab_(config.lab),
      run_id_(run_id),
      recorder_(recorder),
      clock_(clock),
      rights_(config, run_id),
      audit_(recorder, clock) {}

void OperatorDesk::hear(std::string_view channel, std::span<const std::byte> bytes, Now now) {
  const auto slash = channel.rfind('/');
  const std::string peer(slash == std::string_view::npos ? std::string_view() : channel.substr(0, slash));
  operator_command_t message;
  if (!hal::decode(bytes, message)) return refuse(peer, -1, {"undecodable", "it is not an operator_command_t"});
  const int command = message.command.command;
  if (command == operator_command_t::ask) return void(challenge_asked_ = true);
  if (message.lab != lab_) return counters_.add("operator.for_other_lab");
  const auto refusal = closed_ ? ended : rights_.refusal(peer, message, now);
  answer(message.number, refusal ? refusal->why : std::string_view());
  if (refusal) return refuse(peer, command, *refusal);
  admit(peer, channel, message, bytes);
}

void OperatorDesk::answer(std::int64_t number, std::string_view refusal) {
  const auto alike = [&](const operator_answer_t& other) { return other.refusal.empty() == refusal.empty(); };
  if (std::ranges::count_if(answers_, alike) == most_answers) answers_.erase(std::ranges::find_if(answers_, alike));
  operator_answer_t& added = answers_.emplace_back();
  added.number = number;
  added.refusal = refusal;
}

std::vector<operator_answer_t> OperatorDesk::take_answers(Now now) {
  if (std::exchange(challenge_asked_, false)) answers_.emplace_back();
  for (operator_answer_t& each : answers_) {
    each.lab = lab_;
    each.run_id = static_cast<std::int64_t>(run_id_);
    each.clock_us = now.count();
  }
  return std::exchange(answers_, {});
}

std::string OperatorDesk::perform(std::uint8_t command, Now now) {
  operator_command_t message{};
  message.lab = lab_;
  message.run_id = static_cast<std::int64_t>(run_id_);
  message.clock_us = now.count();
  message.command.command = command;
  if (const auto refusal = closed_ ? ended : rights_.refusal_here(message, now)) {
    refuse({}, command, *refusal);
    return refusal->sentence;
  }
  // Nobody but this process vouches for it: no number, and a proof of zeros.
  const std::vector<std::uint8_t> bytes = proved_bytes(message);
  admit({}, operator_channel, message, std::as_bytes(std::span(bytes)));
  return {};
}

void OperatorDesk::admit(const std::string& peer, std::string_view channel, const operator_command_t& message,
                         std::span<const std::byte> bytes) {
  const int command = message.command.command;
  audit_.note(peer, word_of(command), CommandAudit::admitted);
  recorder_.record(clock_.now(), channel, bytes);
  if (command == operator_command_t::stop)
    end_asked_ = true;
  else if (command != operator_command_t::arm && command != operator_command_t::disarm)
    for_robots_.push_back({peer, message.command});
}

void OperatorDesk::refuse(const std::string& peer, int command, const Refusal& refusal) {
  audit_.note(peer, command < 0 ? "" : word_of(command), refusal.why);
  const std::string counter = fmt::format("operator.refused.{}", refusal.why);
  counters_.add(counter);
  if (said_.emplace(refusal.why).second)
    spdlog::warn("{} refused a command on {}: {}; further refusals are counted as {}", lab_,
                 peer.empty() ? operator_channel : hal::printable(peer, hal::max_lab_name) + '/' + operator_channel,
                 refusal.sentence, counter);
}

hal::Counters OperatorDesk::counters() const {
  hal::Counters all = counters_;
  all.merge(rights_.counters());
  return all;
}

}  // namespace arkmesh::lab
