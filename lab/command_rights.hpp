// Which commands of operators a lab admits: those that are proved to be its own user's, for this run of it, and new.
// The caller owns time.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "arkmesh/operator_command_t.hpp"
#include "lab/operator_key.hpp"
#include "lab/state_rules.hpp"

namespace arkmesh::lab {

class CommandRights {
 public:
  using Now = std::chrono::microseconds;

  CommandRights(std::string lab, std::uint64_t run_id, OperatorKey key);

  // Why the lab does not do it. Nothing: it does, and never again by the same message.
  std::optional<Refusal> refusal(const operator_command_t& message, Now now);
  std::int64_t newest() const { return newest_; }  // number of the newest command that was admitted

 private:
  std::optional<Refusal> unproved(const operator_command_t& message, Now now);

  const std::string lab_;
  const std::int64_t run_id_;
  OperatorKey key_;
  std::string no_key_;  // why it cannot be read
  std::optional<Now> read_;
  std::int64_t newest_ = 0;
};

}  // namespace arkmesh::lab
