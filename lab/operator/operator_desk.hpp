// Where commands of operators come in: judges each, counts and says what it refuses, records what it admits,
// and keeps the books about both.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "arkmesh/fleet_command_t.hpp"
#include "arkmesh/operator_answer_t.hpp"
#include "arkmesh/operator_command_t.hpp"
#include "hal/counters.hpp"
#include "hal/record/recorder.hpp"
#include "hal/time/clock.hpp"
#include "lab/operator/command_audit.hpp"
#include "lab/operator/command_rights.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::lab {

class OperatorDesk {
 public:
  using Now = CommandRights::Now;

  // Recorder and clock outlive it.
  OperatorDesk(const RunConfig& config, std::uint64_t run_id, hal::Recorder& recorder, const hal::Clock& clock);

  // As CommandRights.
  void ask(HasSigned has_signed) { rights_.ask(std::move(has_signed)); }
  bool armed() const { return rights_.armed(); }
  // A message of the public bus, which anybody on this machine may have sent: on operator_channel of the own operator,
  // behind "<lab>/" of another lab's.
  void hear(std::string_view channel, std::span<const std::byte> bytes, Now now);
  // What the own operator says in this process, which knows who they are: a fleet_command_t::command, or one of
  // operator_command_t. Returns why it is refused, in one sentence; nothing when it is not.
  std::string perform(std::uint8_t command, Now now);
  // What was admitted for the robots since the last call, and whose it is: another lab's operator's, or with an empty
  // name the own one's.
  struct ForRobots {
    std::string peer;
    fleet_command_t command;
  };
  std::vector<ForRobots> take() { return std::exchange(for_robots_, {}); }
  // To the last commands since it was called before, the oldest first, and a challenge to who asked for one. A flood of
  // commands that are refused drives out no other answer.
  std::vector<operator_answer_t> take_answers(Now now);
  // Somebody waits for an answer.
  bool is_asked() const { return challenge_asked_ || !answers_.empty(); }
  // The run is to end.
  bool end_asked() const { return end_asked_; }
  // From now on everything is refused.
  void close() { closed_ = true, rights_.disarm(); }
  hal::Counters counters() const;

 private:
  void admit(const std::string& peer, std::string_view channel, const operator_command_t& message,
             std::span<const std::byte> bytes);
  void refuse(const std::string& peer, int command, const Refusal& refusal);
  void answer(std::int64_t number, std::string_view refusal);

  const std::string lab_;
  const std::uint64_t run_id_;
  hal::Recorder& recorder_;
  const hal::Clock& clock_;
  CommandRights rights_;
  CommandAudit audit_;
  std::vector<ForRobots> for_robots_;
  std::vector<operator_answer_t> answers_;
  bool end_asked_ = false, closed_ = false, challenge_asked_ = false;
  std::set<std::string, std::less<>> said_;  // reasons of refusals
  hal::Counters counters_;
};

}  // namespace arkmesh::lab
