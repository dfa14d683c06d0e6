#include "lab/operator_desk.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <optional>
#include <utility>

#include "hal/bus.hpp"
#include "lab/message_check.hpp"

namespace arkmesh::lab {

OperatorDesk::OperatorDesk(const RunConfig& config, std::uint64_t run_id, hal::Recorder& recorder,
                           const hal::Clock& clock)
    : lab_(config.lab),
      recorder_(recorder),
      clock_(clock),
      rights_(config.lab, run_id, OperatorKey(config.operator_key)) {}

void OperatorDesk::hear(std::string_view channel, std::span<const std::byte> bytes, Now now) {
  operator_command_t message;
  if (!check_operator_command(bytes).empty() || !hal::decode(bytes, message))
    return refuse({"undecodable", "it is no operator_command_t"});
  if (closed_) return refuse({"ended", "the run has ended"});
  if (const auto refusal = rights_.refusal(message, now)) return refuse(*refusal);
  counters_.add("operator.commands");
  recorder_.record(clock_.now(), channel, bytes);
  if (message.command.command == operator_command_t::stop)
    end_asked_ = true;
  else
    for_robots_.push_back(message.command);
}

void OperatorDesk::refuse(const Refusal& refusal) {
  const std::string counter = fmt::format("operator.refused.{}", refusal.why);
  counters_.add(counter);
  if (said_.emplace(refusal.why).second)
    spdlog::warn("{} refused a command of an operator: {}; further ones are counted as {}", lab_, refusal.sentence,
                 counter);
}

std::vector<fleet_command_t> OperatorDesk::take() {
  return std::exchange(for_robots_, {});
}

hal::Counters OperatorDesk::counters() const {
  hal::Counters all = counters_;
  if (rights_.newest() > 0) all.set("operator.number", static_cast<std::uint64_t>(rights_.newest()));
  return all;
}

}  // namespace arkmesh::lab
