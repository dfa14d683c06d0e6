// One lab's run: arena, scenario and period gate joined over the lab's private bus, as a resumable step. The caller
// owns time: a lab process passes monotonic wall time, `arkmesh run` passes step time; neither reaches a result.
// Single-threaded.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hal/arena.hpp"
#include "hal/bus.hpp"
#include "hal/recorder.hpp"
#include "lab/behaviour_hash.hpp"
#include "lab/peer_monitor.hpp"
#include "lab/period_gate.hpp"
#include "lab/run_config.hpp"
#include "lab/scenario.hpp"

namespace arkmesh::lab {

class LabRun {
 public:
  using Now = std::chrono::microseconds;  // monotonic, any origin

  enum class Step {
    advanced,  // did something; call again
    waiting,  // can do nothing before a message comes, a timer is due or the arena wants service: serve the buses for a
              // while, then call again
    ended,    // over; see finished() and reason()
  };

  // The references outlive the run. `settings` is what all labs must have alike (shared_settings).
  LabRun(RunConfig config, std::map<std::string, std::string, std::less<>> settings, hal::Arena& arena,
         Scenario& scenario, hal::Bus& private_bus, hal::Recorder& recorder, std::uint64_t nonce);
  ~LabRun();

  // Handles what is on the private bus, then at most one frame or one boundary. Throws what arena or scenario throw.
  Step step(Now now);
  // The last step found the arena on its way to where the lab wants it; the arena's next_service() says when to call
  // again.
  bool awaits_arena() const { return awaits_arena_; }
  // Ends the run as failed, as if a peer had gone: says so to others first. For the operator's Ctrl-C.
  void stop(std::string_view why);

  bool finished() const {
    return phase_ == Phase::ended && !failed_;
  }                                                              // reached the last boundary and has the final hash
  const std::string& reason() const { return reason_; }          // why it failed
  const std::string& state_text() const { return state_text_; }  // what it is doing, for progress and `status`
  std::uint32_t period() const { return lab_.period(); }
  std::uint32_t last_period() const { return gate_.last_period(); }
  const RunConfig& config() const { return config_; }
  const Lab& lab() const { return lab_; }
  bool strict() const { return gate_.mode() == PeriodGate::Mode::strict; }
  // Hash of each lab at the last boundary, and all of them in name order as one. A lab never heard has 0.
  std::map<std::string, std::uint64_t> hash_by_lab() const;
  std::uint64_t final_hash() const;
  // Everything dropped, replaced, late or refused in this lab, by reason.
  hal::Counters drops() const;
  // Commands of an operator on the lab's public bus (fleet_command_t). They are no part of a reproducible run.
  static inline const std::string operator_channel = "operator_command";

 private:
  enum class Phase { starting, opening, at_boundary, running, completing, lingering, failing, ended };

  void enter(Phase phase);
  void begin();
  bool next_event();
  bool advance(hal::LabTime t);
  Step wait_for_arena();
  void deliver();
  void close_period();
  void merge_period();
  bool follow_rooms();
  void publish_world();
  void publish_status();
  void hear_world(std::string_view channel, std::span<const std::byte> bytes);
  std::string_view why_refused(std::string_view lab, const LabState& state, const LabState& first) const;
  Step wait(std::uint32_t wanted);
  void fail(std::string_view why);
  void finish();
  Step linger();
  void set_state_text(std::string text);

  RunConfig config_;
  std::map<std::string, std::string, std::less<>> settings_;
  hal::Arena& arena_;
  Scenario& scenario_;
  hal::Bus& bus_;
  hal::Recorder& recorder_;
  const std::uint64_t nonce_;
  Lab lab_;
  PeriodGate gate_;
  PeerMonitor watch_;
  BehaviourHash hash_;
  hal::PoseFrame frame_;          // the newest
  std::uint32_t next_frame_ = 0;  // number of the next frame to come
  Phase phase_ = Phase::starting;
  bool failed_ = false, awaits_arena_ = false;
  std::string reason_, state_text_ = "starting";
  std::uint32_t boundary_ = 0;        // the one whose own state was published last
  Now now_{0};                        // of the current step
  Now world_due_{0}, status_due_{0};  // when to repeat
  Now waiting_since_{0}, began_period_{0}, last_news_{0}, moved_at_{-1};
  Now linger_until_{0}, acknowledged_at_{-1};
  hal::Counters counters_;
  std::vector<std::unique_ptr<hal::Bus::Subscription>> subscriptions_;
};

}  // namespace arkmesh::lab
