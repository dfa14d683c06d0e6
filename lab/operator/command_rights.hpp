// Which commands of operators a lab admits: those that are proved to be its own user's, or those of labs that have the
// permission; meant for this run and new. To let robots run, another lab's command needs an armed lab, too, and may not
// come too often; to make them stand it needs neither. The caller owns time.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "arkmesh/operator_command_t.hpp"
#include "hal/counters.hpp"
#include "lab/exchange/state_rules.hpp"
#include "lab/operator/operator_key.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::lab {

// Whether a lab has signed the bytes with its own key. False for one that is not trusted, or not any more.
using HasSigned = std::function<bool(const std::string& peer, std::span<const std::uint8_t> bytes,
                                     std::span<const std::uint8_t> signature)>;

class CommandRights {
 public:
  using Now = std::chrono::microseconds;

  CommandRights(const RunConfig& config, std::uint64_t run_id);
  // Without it no command of other labs is admitted.
  void ask(HasSigned has_signed) { has_signed_ = std::move(has_signed); }

  // Why the lab does not do it. Nothing: it does, and never again by the same message. `peer`: the lab whose operator
  // gave it; empty: this one's.
  std::optional<Refusal> refusal(const std::string& peer, const operator_command_t& message, Now now);
  // The same of one that the own operator gives in this process, which knows who they are: nothing is to be proved.
  std::optional<Refusal> refusal_here(const operator_command_t& message, Now now);
  // Whether other labs' operators may let robots run. Not before the own operator has said so.
  bool armed() const { return armed_; }
  void disarm() { armed_ = false; }

  // Whether the lab is armed, if anybody has permission; of whom how many were admitted.
  hal::Counters counters() const;

 private:
  struct Giver {
    std::map<std::int64_t, Now> used;  // numbers of commands admitted that are not too old yet, and their clock
    std::uint64_t admitted = 0;
    std::optional<Now> last_run;  // when it resumed last
  };
  std::optional<Refusal> forbidden(const std::string& peer, const operator_command_t& message, Now now) const;
  std::optional<Refusal> unfit(const Giver& giver, const operator_command_t& message, Now now) const;
  std::optional<Refusal> admit(const std::string& peer, Giver& giver, const fleet_command_t& given, Now now);
  std::optional<Refusal> unproved(const operator_command_t& message, Now now);
  std::optional<Refusal> unsigned_by(const std::string& peer, const operator_command_t& message, Now now);

  const std::string lab_;
  const std::int64_t run_id_;
  const Now gap_;  // least time between two times that a peer resumes
  OperatorKey key_;
  std::string no_key_;                  // why it cannot be read
  Now read_{std::chrono::seconds(-1)};  // when it was tried last
  HasSigned has_signed_;
  Now looks_begun_{0};  // of the second in which signatures were looked at so often
  int looks_ = 0;
  bool armed_ = false;
  std::map<std::string, Giver, std::less<>> givers_;  // "": the own operator; those with permission
};

}  // namespace arkmesh::lab
