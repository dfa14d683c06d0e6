// Runs one lab: joins arena, scenario and period gate over the lab's private bus, as a resumable step. The caller owns
// time: a lab process passes monotonic wall time, `arkmesh run` passes step time; neither reaches a result. Nothing
// here blocks: the caller waits, in one place, for messages and for the arena. Single-threaded.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arkmesh/shared_view_t.hpp"
#include "hal/arenas/arena.hpp"
#include "hal/bus/bus.hpp"
#include "hal/record/recorder.hpp"
#include "lab/arena_port.hpp"
#include "lab/exchange/peer_exchange.hpp"
#include "lab/lab_data.hpp"
#include "lab/operator/operator_desk.hpp"
#include "lab/own_state.hpp"
#include "lab/robots/robot_book.hpp"
#include "lab/run_config.hpp"
#include "lab/scenario.hpp"
#include "lab/status.hpp"

namespace arkmesh::lab {

class Runner {
 public:
  using Now = std::chrono::microseconds;  // monotonic, any origin

  enum class Step {
    advanced,  // did something; call again
    waiting,   // can do nothing before a message comes, due() is there, the arena wants service or the scenario has
               // settled: serve the buses meanwhile, then call again
    ended,     // over; see finished() and reason()
  };

  // The references outlive the runner. `settings` is what all labs must have alike (shared_settings). `worlds` may be
  // that of all labs of this process.
  Runner(RunConfig config, std::map<std::string, std::string, std::less<>> settings, hal::Arena& arena,
         Scenario& scenario, hal::Bus& private_bus, hal::Recorder& recorder, std::uint64_t run_id,
         std::shared_ptr<WorldReader> worlds = std::make_shared<WorldReader>());

  // Serves the arena, handles what is on the private bus, says in the status each second how it is, then handles at
  // most one frame or one boundary; none after the end, while the arena ends. What arena or scenario throw ends the run
  // as failed. The last thing that robots hear is a word after which they stand.
  Step step(Now now);
  // When step() is wanted at the latest after it has waited.
  Now due() const { return awaits_arena_ ? status_due_ : std::min(status_due_, peers_.world_due()); }
  // What came on the public bus for the lab's operators (operator_channel). The next step does it, when it is admitted.
  void hear_command(std::string_view channel, std::span<const std::byte> bytes) {
    operators_.hear(channel, bytes, now_);
  }
  // What the lab's own operator says in this process, at its page. As OperatorDesk::obey.
  std::string perform(std::uint8_t command) { return operators_.perform(command, now_); }
  // Of other labs' operators.
  void ask(HasSigned has_signed) { operators_.ask(std::move(has_signed)); }
  bool armed() const { return operators_.armed(); }
  Now now() const { return now_; }  // of the current step
  // Ends the run early and says why to others first: as the operator wishes, or as failed. A run that has finished
  // stays so, and the lab goes soon.
  void stop(std::string_view why);
  void fail(std::string_view why);
  // The last step found the arena on its way to where the lab wants it: call again at the arena's next_service() at the
  // latest.
  bool awaits_arena() const { return awaits_arena_; }
  // The last step found the scenario still computing: call again soon. await_scenario() waits for it, at most so long.
  bool awaits_scenario() const { return awaits_scenario_; }
  void await_scenario(std::chrono::milliseconds wait);

  // It reached the last boundary and has the final hash.
  bool finished() const { return phase_ == Phase::ended && !failed_; }
  // It lingers after the last boundary, and by what it knows no peer lacks anything. Who knows that of all labs,
  // because they are in its process, lets them leave: nobody needs repetitions then.
  bool complete() const { return phase_ == Phase::lingering && peers_.complete(); }
  void leave_complete() { peers_.leave_complete(); }
  // Of how it ended, in one word: "finished", "stopped" by its operator or a peer's, "failed"; "running" before. It is
  // known before the lab has told everybody.
  std::string_view outcome() const;
  const hal::Recorder& recorder() const { return recorder_; }
  const std::string& reason() const { return reason_; }  // why it ended early
  std::string state_text() const;                        // what it is doing, for progress and `status`
  // How far it is, and what came of it: constants of lab_status_t.
  std::uint8_t phase() const;
  std::uint8_t outcome_code() const;
  const RobotBook& robot_book() const { return book_; }
  // Of robots that should stand those that were not seen to.
  std::vector<hal::NotStanding> not_standing() const;
  // None of them, but for robots that safety.missing lets go.
  bool robots_stand() const { return stand(not_standing(), may_be_missing()); }
  std::size_t may_be_missing() const { return config_.safety.may_be_missing(arena_.info().robots.size()); }
  std::uint32_t period() const { return data_.period; }
  std::uint32_t last_period() const { return peers_.gate().last_period(); }
  const RunConfig& config() const { return config_; }
  const Lab& lab() const { return lab_; }
  const hal::Arena& arena() const { return arena_; }
  std::uint64_t run_id() const { return run_id_; }
  std::uint64_t settings_hash() const { return own_.settings_hash(); }
  Now moving() const { return moved_ ? now_ - *moved_ : Now{0}; }  // for how long its robots have moved; 0 not yet
  bool strict() const { return peers_.strict(); }
  // Hash of each lab at the last boundary, and all of them in name order as one. A lab never heard has 0.
  std::map<std::string, std::uint64_t> hash_by_lab() const { return peers_.hash_by_lab(own_.hash()); }
  std::uint64_t final_hash() const { return joint_hash(hash_by_lab()); }
  // Every counter of this lab.
  hal::Counters drops() const;
  // What the exchange with peers cost, and how fresh it was: "exchange" of result.json.
  nlohmann::json exchange_figures() const;
  // Counts that bus's, too, as `public_bus.*`; null: no longer.
  void count(const hal::Bus* public_bus) { public_bus_ = public_bus; }
  // Counts what is counted at the lab's page, too; null: no longer.
  void count_page(const hal::Counting* page) { page_ = page; }

 private:
  enum class Phase { starting, at_boundary, running, completing, lingering, failing, ended };

  Step go_on();
  Step start();
  Step next_event();
  bool advance_to(hal::LabTime t);
  void deliver();
  void tell_events();
  void close_period();
  Step merge_period();
  void end_period();
  bool settled();
  void fail_at_period(std::string_view why);
  void look_for_lost_peers();
  void end_without(const PeerWait& peer);
  void keep_still(RobotBook::Who who, bool still, bool& kept);
  void lose_arena(std::string_view why);
  void publish_status();
  Step wait();
  Step wait_for_arena();
  Step wait_for_peers(std::uint32_t wanted);
  void finish();
  void end_robots();
  void say_last(std::string state);
  Step linger();
  void enter(Phase phase);

  const RunConfig config_;
  hal::Arena& arena_;
  Scenario& scenario_;
  hal::Bus& bus_;
  const hal::Bus* public_bus_ = nullptr;
  const hal::Counting* page_ = nullptr;
  hal::Recorder& recorder_;
  const std::uint64_t run_id_;
  std::unique_ptr<hal::Bus::Subscription>
      recording_;  // the first of all, so that nothing happens before it is recorded
  ArenaPort port_;
  LabData data_;
  Lab lab_{data_};
  RobotBook book_;
  OperatorDesk operators_;
  PeerExchange peers_;
  OwnState own_;
  Phase phase_ = Phase::starting;
  bool begun_ = false, failed_ = false, stopped_ = false, awaits_arena_ = false;
  bool asked_ = false;            // the scenario, which may not have settled
  bool awaits_scenario_ = false;  // it has not
  shared_view_t view_;            // of the boundary at which it was asked
  bool met_ = false;              // the arena may start: it need not wait for the other labs, or they are there
  bool arena_lost_ = false, arena_ended_ = false;  // it failed after the run's end and is left alone
  bool peers_done_ = false;                        // none waits for this lab any more
  bool peer_lost_ = false, no_news_ = false;       // robots stand still until that is over
  std::string reason_;
  StateText state_;
  std::uint32_t next_frame_ = 0;  // number of the next frame to come
  std::uint32_t boundary_ = 0;    // the one whose own state was published last
  Now now_{0};                    // of the current step
  Now status_due_{0}, status_said_{0};
  Now look_due_{0};           // at peers that are waited for
  std::optional<Now> moved_;  // when the first period was over
};

}  // namespace arkmesh::lab
