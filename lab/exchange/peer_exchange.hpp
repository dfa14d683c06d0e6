// What a lab and its peers tell each other: hears worlds, statuses and links from the private bus, pairs states at
// boundaries, and repeats the own world. What that says of a peer, and for whom the lab waits, is the business of
// Peers, which sends nothing. The caller owns time.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/bus/bus.hpp"
#include "hal/counters.hpp"
#include "lab/exchange/confirmations.hpp"
#include "lab/exchange/exchange_tally.hpp"
#include "lab/exchange/growth.hpp"
#include "lab/exchange/lab_state.hpp"
#include "lab/exchange/peers.hpp"
#include "lab/exchange/period_gate.hpp"
#include "lab/exchange/world_reader.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::lab {

class PeerExchange {
 public:
  using Now = Peers::Now;

  // The bus outlives the exchange. `arena`: the own one. `run_id`: of this run, never 0. `worlds` may be that of all
  // labs of this process.
  PeerExchange(const RunConfig& config, const hal::ArenaInfo& arena, std::uint64_t run_id, hal::Bus& private_bus,
               std::shared_ptr<WorldReader> worlds = std::make_shared<WorldReader>());
  PeerExchange(const PeerExchange&) = delete;

  // Called with each world and status of other labs, which nobody else need record: `accepted` or not.
  using Recording = std::function<void(std::string_view channel, std::span<const std::byte> bytes, bool accepted)>;
  void on_heard(Recording recording) { recording_ = std::move(recording); }
  // Carries what grows between labs, from the next message on. It outlives the exchange.
  void carry(Growth* growth) { growth_ = growth; }

  // Time of the current step: to be set before the bus is drained.
  void set_now(Now now) { peers_.set_now(now); }
  // What was heard that ends the run, in one sentence; empty when nothing was.
  const std::string& failure() const { return failure_; }

  PeriodGate& gate() { return gate_; }
  const PeriodGate& gate() const { return gate_; }
  bool strict() const { return gate_.mode() == PeriodGate::Mode::strict; }

  // Publishes the own state of the next boundary.
  void publish(LabState own);
  // Free mode: what became so before the next boundary (OwnState::event).
  void publish_early(LabState event);
  // As PeriodGate::merge; from now on the lab has passed boundary `k`.
  std::vector<MergedState> merge(std::uint32_t k);
  // As PeriodGate::may_merge. Free mode, arena that can wait: with the states of that boundary of the real-time arenas;
  // without a state of any of them for two periods, at real time by the own clock. One that starts with labs: with the
  // states of all that it does not go on without.
  bool may_merge(std::uint32_t k) const;
  void publish_world();
  bool repeat_world();  // when it is due; says whether it was
  // Once after each drain of the bus: one world for all who asked for it meanwhile. Says whether anybody did.
  bool answer();
  Now world_due() const { return world_due_; }

  // As in Peers.
  void note_unsent(std::uint64_t total) { peers_.note_unsent(total); }
  bool all_met() const { return peers_.all_met(); }
  PeerWait wait_for(std::uint32_t wanted) const { return peers_.wait_for(wanted); }
  PeerLook look() { return peers_.look(); }
  void linger_after_failure() { peers_.linger_after_failure(); }
  void linger_after_last_period();
  void hurry() { peers_.hurry(); }
  bool may_leave(std::uint32_t last) { return peers_.may_leave(last); }
  bool complete() const { return peers_.complete(); }
  void leave_complete() { peers_.leave_complete(); }

  // Hash of each lab in its newest state, `own` the own one. A lab never heard has 0.
  std::map<std::string, std::uint64_t> hash_by_lab(std::uint64_t own) const;
  // Everything refused, late or missing.
  hal::Counters counters() const;
  // As "exchange" of result.json.
  nlohmann::json exchange_figures() const;

 private:
  // By events: the own ones have come through as far as others say.
  void note_confirmed(const std::vector<MergedState>& merged);
  // False: it was not accepted.
  bool hear_world(std::string_view origin, std::span<const std::byte> bytes);
  void owe_answer(std::string_view peer);

  const std::string lab_, owner_;
  const Exchange exchange_;
  const bool by_events_;  // the own payloads go by event
  const bool with_labs_;  // hal::ArenaInfo::starts_with_labs
  const std::chrono::microseconds period_length_;
  const std::size_t max_message_bytes_;
  hal::Bus& bus_;
  const std::shared_ptr<WorldReader> worlds_;
  PeriodGate gate_;
  Peers peers_;
  Confirmations events_;
  ExchangeTally tally_;
  Growth* growth_ = nullptr;
  bool complete_ = false;  // lingers after the last period
  std::string failure_;
  std::map<std::string, Now, std::less<>> answered_;  // peers that did not know our run id, and when
  bool owes_answer_ = false;
  Now world_due_{0}, merged_{0}, last_state_{0};
  hal::Counters counters_;
  Recording recording_;
  std::vector<std::unique_ptr<hal::Bus::Subscription>> subscriptions_;
};

}  // namespace arkmesh::lab
