// A lab that runs, as its status on a bus tells.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/operator_answer_t.hpp"
#include "arkmesh/operator_command_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/arenas/robot_words.hpp"
#include "hal/bus/bus.hpp"
#include "hal/bus/bus_config.hpp"
#include "lab/safety_config.hpp"

namespace arkmesh::lab {

class RunningLab {
 public:
  // The lab `name`, or whichever it is, whose bus this is; or lab `name`, a peer of `own`, whose bus this is. What says
  // that it is another one is not believed: a command for it would be carried there.
  RunningLab(const hal::BusConfig& bus, const std::string& name, const std::string& own = {});

  // False when it has said nothing within the time that labs take for it.
  bool speaks() {
    return comes_to(std::chrono::milliseconds(2500), [] { return true; });
  }
  // What it said last.
  const lab_status_t& status() const { return status_; }
  // Its outcome is known; it may still tell its robots to stand, or wait for its peers.
  bool is_over() const { return status_.outcome != lab_status_t::open; }
  // It has said its last word; or none for some seconds, when it was over already.
  bool has_ended() const { return status_.phase == lab_status_t::ended || (is_over() && is_silent()); }
  // Robots should do something else than run.
  bool should_stand() const { return status_.wanted != lab_status_t::run; }
  // Of robots that should stand those that were not seen to, in words; empty: none.
  std::string not_standing() const { return hal::in_words(not_seen_); }
  // Robots should stand, and were seen to, but for those that the lab's safety.missing lets go.
  bool stands() const { return should_stand() && stand(not_seen_, static_cast<std::size_t>(status_.may_be_missing)); }

  // Gives it a command until it answers, three times at most. `prove` fills in the proof. Returns what became of it:
  // nothing when it was admitted, else why not, in one sentence.
  std::string tell(std::uint8_t command, const std::function<void(operator_command_t&)>& prove);
  // False when it has not come to that in time.
  bool comes_to(std::chrono::milliseconds within, const std::function<bool()>& condition);

  bool is_silent() const { return std::chrono::steady_clock::now() - heard_at_ > std::chrono::seconds(3); }

 private:
  bool has_spoken() const { return heard_at_ != std::chrono::steady_clock::time_point{}; }
  void ask();

  hal::Bus bus_;
  const bool other_;  // a peer's, behind gateways
  lab_status_t status_;
  std::vector<hal::NotStanding> not_seen_;            // to stand, as it says
  std::chrono::steady_clock::time_point heard_at_{};  // the epoch: nothing yet
  std::int64_t number_ = 0;                           // of what it should answer; 0: of a challenge
  std::optional<operator_answer_t> answer_;
  std::unique_ptr<hal::Bus::Subscription> statuses_, answers_;
};

}  // namespace arkmesh::lab
