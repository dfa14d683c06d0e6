#include "lab/runner.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "hal/arenas/robot_words.hpp"
#include "hal/bus/loss.hpp"
#include "lab/exchange/shared_view.hpp"
#include "lab/operator/operator_message.hpp"

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr Runner::Now repeat_status = 1s, answer_status = 50ms;
constexpr hal::LabTime repeat_info = 60s;
constexpr Runner::Now look_each = 10ms;  // at peers that are waited for at a boundary; most are there before

// What others say is recorded by those who know whether it was accepted: worlds, statuses, peers by the exchange,
// commands by the operators' desk, which also knows what was answered. Other channels of theirs are not for this lab.
bool is_of_others(std::string_view channel) {
  return channel == operator_channel || channel == answer_channel || channel == hal::channel::peers ||
         channel.find('/') != std::string_view::npos;
}

}  // namespace

Runner::Runner(RunConfig config, std::map<std::string, std::string, std::less<>> settings, hal::Arena& arena,
               Scenario& scenario, hal::Bus& private_bus, hal::Recorder& recorder, std::uint64_t run_id,
               std::shared_ptr<WorldReader> worlds)
    : config_(std::move(config)),
      arena_(arena),
      scenario_(scenario),
      bus_(private_bus),
      recorder_(recorder),
      run_id_(run_id),
      recording_(recorder_.record_all(bus_, arena_.clock(), &is_of_others)),
      port_(arena, private_bus),
      data_(make_lab_data(config_, arena.info())),
      book_(arena, private_bus, data_.words, config_.absent_after),
      operators_(config_, run_id, recorder, arena.clock()),
      peers_(config_, arena.info(), run_id, private_bus, std::move(worlds)),
      own_(std::move(settings), config_.exchange, config_.lab == config_.owner) {
  peers_.carry(&data_.growth);
  peers_.on_heard([this](std::string_view channel, std::span<const std::byte> bytes, bool accepted) {
    const hal::LabTime now = arena_.clock().now();
    return accepted ? recorder_.record(now, channel, bytes) : recorder_.record_refused(now, channel, bytes);
  });
}

// ---------------------------------------------------------------- one step

Runner::Step Runner::step(Now now) {
  now_ = now;
  peers_.set_now(now);
  try {
    if (!arena_lost_) {
      arena_.serve();
      book_.catch_up(arena_.clock().now());
    }
    if (now_ >= status_due_) publish_status();
    bus_.drain();  // also what the status brought here, so that it leaves in this step
    if (peers_.answer()) bus_.drain();
    if (!peers_.failure().empty()) fail(peers_.failure());
    for (const auto& [peer, message] : operators_.take())
      if (const auto command = hal::from_message(message))
        book_.say(RobotBook::Who::operators, *command, arena_.clock().now(),
                  peer.empty() ? "operator" : "operator of " + peer);
    if (operators_.end_asked()) stop("stopped by the operator");
    if (operators_.is_asked()) status_due_ = std::min(status_due_, status_said_ + answer_status);
    if (!strict() && (phase_ == Phase::running || (phase_ == Phase::at_boundary && boundary_ > 0)))
      look_for_lost_peers();
    return go_on();
  } catch (const std::exception& error) {
    if (phase_ < Phase::lingering)
      fail_at_period(error.what());
    else
      lose_arena(error.what());
    return Step::advanced;
  }
}

// Scenario or arena have failed; what the scenario wrote before is not lost.
void Runner::fail_at_period(std::string_view why) {
  write_rows(data_, recorder_);
  fail(fmt::format("{} failed at period {}: {}", config_.lab, data_.period, why));
}

Runner::Step Runner::go_on() {
  switch (phase_) {
    case Phase::starting:
      return start();
    case Phase::running:
      return next_event();
    case Phase::at_boundary:
      if (!asked_ && !peers_.may_merge(boundary_)) return wait_for_peers(peers_.gate().wanted(boundary_));
      return merge_period();
    case Phase::completing:
      if (strict() && !peers_.gate().received_from_all(boundary_)) return wait_for_peers(boundary_);
      finish();
      return Step::advanced;
    case Phase::lingering:
    case Phase::failing:
      return linger();
    case Phase::ended:
      break;
  }
  return Step::ended;
}

Runner::Step Runner::start() {
  if (!std::exchange(begun_, true)) {
    port_.publish_info();
    lab_.declare(arena_rule());
    lab_.declare(unknown_rule());
    lab_.publish(arena_rule().name, arena_values(arena_.info()));
    if (config_.exchange.mode == Exchange::Mode::mixed) lab_.declare(applied_rule(config_.labs.size()));
    scenario_.begin(lab_);
    data_.declaring = false;
    peers_.gate().set_rules({config_.owner, data_.rules, config_.projections});
  }
  met_ = met_ || !arena_.info().starts_with_labs || peers_.all_met();
  if (!met_) return wait_for_peers(0);
  if (!advance_to(hal::LabTime{0})) return wait();
  close_period();
  return Step::advanced;
}

// The next frame or boundary, whichever is first; the calls of advance_to depend on our own configuration only.
Runner::Step Runner::next_event() {
  const hal::LabTime boundary = config_.period * (data_.period + 1);
  const hal::LabTime frame = arena_.info().frame_period * next_frame_;
  if (!advance_to(std::min(frame, boundary))) return wait();
  if (frame >= boundary) {
    if (!moved_) moved_ = now_;
    close_period();
  }
  return Step::advanced;
}

// False: the arena is not there yet, or the scenario has not settled. Called again with the same t, it goes on.
bool Runner::advance_to(hal::LabTime t) {
  if (!asked_) {
    if (!arena_.advance_to(t)) return false;
    if (std::exchange(awaits_arena_, false)) state_.goes_on();
    const ArenaPort::Snapshot snapshot = port_.take_snapshot();
    asked_ = snapshot.frame || !snapshot.heard.empty();
    if (snapshot.frame) {
      own_.add(*snapshot.frame);
      if (!arena_.info().can_wait) book_.see(*snapshot.frame);
      data_.now = snapshot.frame->stamp;
      scenario_.on_poses(lab_, *snapshot.frame);
    }
    if (!snapshot.heard.empty()) {
      data_.now = t;
      scenario_.on_heard(lab_, snapshot.heard);
    }
  }
  if (asked_) {
    if (!settled()) {
      bus_.drain();  // others see the frame meanwhile
      return false;
    }
    deliver();
    tell_events();
    bus_.drain();
  }
  if (arena_.info().frame_period * next_frame_ <= t) ++next_frame_;
  return true;
}

// True once for each call of the scenario.
bool Runner::settled() {
  awaits_scenario_ = !scenario_.settled(lab_, 0ms);
  if (!awaits_scenario_) asked_ = false;
  return !awaits_scenario_;
}

void Runner::await_scenario(std::chrono::milliseconds wait) {
  if (!awaits_scenario_ || phase_ >= Phase::lingering) return;
  try {
    scenario_.settled(lab_, wait);
  } catch (const std::exception& error) {
    fail_at_period(error.what());
  }
}

// What the scenario said: to robots as one batch, from the first merge on, and to people.
void Runner::deliver() {
  data_.words.retell(data_.now, own_.frame().robots, data_.to_robots);
  if (!data_.states.empty()) port_.say(std::exchange(data_.to_robots, {}), data_.now, own_.frame().number);
  book_.prepare(data_.parameters);
  for (const hal::FleetCommand& command : data_.commands) book_.say(RobotBook::Who::scenario, command, data_.now);
  write_rows(data_, recorder_);
  forget_sent(data_);
}

// Where nobody waits for a boundary, what changes is told at once. Where labs wait, nobody may apply it before, so that
// it would only cost bytes.
void Runner::tell_events() {
  if (phase_ != Phase::running || peers_.gate().mode() != PeriodGate::Mode::free) return;
  if (data_.now >= config_.period * (data_.period + 1)) return;  // the boundary itself tells it
  if (auto event = own_.event(data_); event && !peers_.gate().own_refusal(*event))
    peers_.publish_early(std::move(*event));
}

// ---------------------------------------------------------------- boundaries

// Builds and publishes the own state of the boundary that lab time has reached.
void Runner::close_period() {
  boundary_ = static_cast<std::uint32_t>(peers_.gate().published() + 1);
  LabState own = own_.at_boundary(boundary_, data_);
  if (const auto refused = peers_.gate().own_refusal(own))
    return fail(fmt::format("{} breaks its own rules at period {}: {}; correct the scenario or its declarations",
                            config_.lab, boundary_, refused->sentence));
  recorder_.row("hash", "period,hash", fmt::format("{},{:016x}", boundary_, own.hash));
  peers_.publish(std::move(own));
  look_due_ = now_ + look_each;
  enter(Phase::at_boundary);
}

Runner::Step Runner::merge_period() {
  const std::uint32_t k = boundary_;
  if (!asked_) {
    if (k == 0 && config_.require_strict && !strict()) {
      fail("gate.mode is \"strict\", but an arena of this shared world cannot wait; set gate.mode = \"auto\"");
      return Step::advanced;
    }
    const auto merged = peers_.merge(k);
    tell_merged(data_, k, merged);
    view_ = shared_view(data_, merged);
    if (config_.exchange.mode == Exchange::Mode::mixed && config_.lab == config_.owner)
      lab_.publish(applied_rule(merged.size()).name, payload_periods(merged));
    using Rule = Growth::Rule;
    const bool alike = strict() || config_.labs.size() == 1;
    data_.growth.begin(k, alike ? Rule::alike : lab_.is_owner() ? Rule::decides : Rule::follows);
    scenario_.on_period(lab_);
    asked_ = true;
  }
  if (!settled()) return Step::waiting;
  end_period();
  return Step::advanced;
}

// The scenario has said all that it has to say at the boundary.
void Runner::end_period() {
  const std::uint32_t k = boundary_;
  data_.growth.end();
  if (k == 0) recorder_.start_now();
  add_curves(data_);
  deliver();
  if (k == 0) book_.begin(data_.now);  // robots move once all states 0 are merged
  publish_shared(bus_, data_, view_);
  if (data_.now % repeat_info == hal::LabTime{0}) port_.publish_info();
  bus_.drain();
  recorder_.flush_period();
  state_.has_merged();
  PeriodGate& gate = peers_.gate();
  if (scenario_.finished(lab_)) gate.finish_at(k);
  // In free mode the owner's end is everybody's: who is behind goes on to that boundary.
  if (!strict() && config_.lab != config_.owner && gate.done(config_.owner))
    gate.finish_at(static_cast<std::uint32_t>(
        std::clamp<std::int64_t>(gate.ended_at(config_.owner), k, std::max(k, gate.last_period()))));
  if (k < gate.last_period()) return enter(Phase::running);
  if (peer_lost_ || no_news_)
    return fail(fmt::format("{} reached its last period {} without a peer: {}", config_.lab, k, state_.does));
  peers_.publish_world();  // now with `done`
  enter(Phase::completing);
}

// ---------------------------------------------------------------- waiting and ending

// Free mode: lab time goes on without a peer that is lost, with robots that stand still or not.
void Runner::look_for_lost_peers() {
  const auto [lost, silence] = peers_.look();
  if (!lost.give_up.empty()) return end_without(lost);
  const bool pauses = !lost.text.empty() && config_.on_peer_lost == RunConfig::OnPeerLost::pause;
  keep_still(RobotBook::Who::lost_peer, pauses, peer_lost_);
  keep_still(RobotBook::Who::safety, !silence.empty(), no_news_);
  const bool paused = peer_lost_ || no_news_;
  if (!lost.text.empty())
    state_.does = fmt::format("{} without {}", paused ? "paused" : "running", lost.text);
  else
    state_.does = paused ? "paused: " + silence : "running";
}

// `kept`: whether it was so before.
void Runner::keep_still(RobotBook::Who who, bool still, bool& kept) {
  using Kind = hal::FleetCommand::Kind;
  if (std::exchange(kept, still) == still) return;
  book_.say(who, {.kind = still ? Kind::pause : Kind::run}, arena_.clock().now());
}

Runner::Step Runner::wait() {
  return awaits_scenario_ ? Step::waiting : wait_for_arena();
}

Runner::Step Runner::wait_for_arena() {
  awaits_arena_ = true;
  if (const std::string wanted = arena_.waiting_for(); !wanted.empty()) state_.waits = "waiting for " + wanted;
  return Step::waiting;
}

// `wanted`: the period of the peers' states that is waited for.
Runner::Step Runner::wait_for_peers(std::uint32_t wanted) {
  peers_.repeat_world();
  if (now_ < look_due_) return Step::waiting;
  look_due_ = now_ + look_each;
  const PeerWait wait = peers_.wait_for(wanted);
  if (!wait.text.empty()) state_.waits = wait.text;
  if (wait.give_up.empty()) return Step::waiting;
  end_without(wait);
  return Step::advanced;
}

// A failure is never overridden.
void Runner::enter(Phase phase) {
  if (!failed_) phase_ = phase;
}

void Runner::stop(std::string_view why) {
  if (phase_ == Phase::lingering) return peers_.hurry();  // it has finished, and the result stands
  stopped_ = stopped_ || !failed_;
  fail(hal::stopped(why, arena_));
}

// Whose peer was stopped is stopped, too.
void Runner::end_without(const PeerWait& peer) {
  stopped_ = stopped_ || (peer.stopped && !failed_);
  fail(peer.give_up);
}

void Runner::fail(std::string_view why) {
  if (failed_ || phase_ == Phase::ended) return;
  awaits_arena_ = awaits_scenario_ = false;
  reason_ = why;
  enter(Phase::failing);
  failed_ = true;
  end_robots();
  peers_.linger_after_failure();
  say_last((stopped_ ? "" : "failed: ") + reason_);
}

void Runner::finish() {
  enter(Phase::lingering);
  end_robots();
  peers_.linger_after_last_period();
  std::string state = "finished";
  for (const std::string& note : hal::loss_words(drops(), "arena.")) state += "; " + note;
  say_last(std::move(state));
}

// Also an arena that failed is told, as long as it listens.
void Runner::end_robots() {
  operators_.close();
  try {
    book_.end(arena_.clock().now());
  } catch (const std::exception& error) {
    lose_arena(error.what());
  }
}

// The run's end is told all the same.
void Runner::lose_arena(std::string_view why) {
  if (!std::exchange(arena_lost_, true))
    spdlog::warn("the arena of {} failed after the end of the run, so whether its robots have stopped is unknown: {}",
                 config_.lab, why);
}

void Runner::say_last(std::string state) {
  state_ = {.does = std::move(state), .waits = {}};
  publish_status();
  bus_.drain();
  recorder_.flush();
}

// Repeats the last state until every peer has it, or is gone; a failed run repeats its status for a moment. Meanwhile
// the arena sees to it that robots stand.
Runner::Step Runner::linger() {
  if (!arena_lost_ && !arena_ended_) arena_ended_ = arena_.end();
  if (peers_.repeat_world()) bus_.drain();
  peers_done_ = peers_done_ || peers_.may_leave(boundary_);
  awaits_arena_ = !arena_lost_ && !arena_ended_;
  if (!peers_done_ || awaits_arena_) return Step::waiting;
  if (std::exchange(phase_, Phase::ended) != Phase::ended) say_last(state_.does);
  return Step::ended;
}

}  // namespace arkmesh::lab
