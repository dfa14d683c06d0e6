#include "lab/lab_run.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "arkmesh/lab_status_t.hpp"
#include "hal/messages.hpp"
#include "lab/wire_check.hpp"

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr LabRun::Now repeat_world = 50ms, repeat_status = 1s, linger_more = 500ms, linger_most = 60s, fail_linger = 1s;
constexpr hal::LabTime repeat_info = 60s;
// Reserved field of state 0: [width_um, height_um, robots, largest id] of the lab's arena; bounds what its robots can
// claim.
const std::string arena_field = "lab.arena";

}  // namespace

const std::vector<std::int64_t>& Lab::field(std::string_view lab, std::string_view field) const {
  static const std::vector<std::int64_t> none;
  const auto& fields = state(lab).fields;
  const auto it = fields.find(field);
  return it == fields.end() ? none : it->second;
}

const std::vector<std::int64_t>& Lab::initial_field(std::string_view lab, std::string_view field) const {
  static const std::vector<std::int64_t> none;
  const auto& fields = initial_states_.find(lab)->second.fields;
  const auto it = fields.find(field);
  return it == fields.end() ? none : it->second;
}

hal::RandomStream& Lab::random(std::string_view purpose) {
  if (const auto it = streams_.find(purpose); it != streams_.end()) return it->second;
  return streams_.emplace(std::string(purpose), hal::RandomStream(seed_, fmt::format("{}/{}", name_, purpose)))
      .first->second;
}

LabRun::LabRun(RunConfig config, std::map<std::string, std::string, std::less<>> settings, hal::Arena& arena,
               Scenario& scenario, hal::Bus& private_bus, hal::Recorder& recorder, std::uint64_t nonce)
    : config_(std::move(config)),
      settings_(std::move(settings)),
      arena_(arena),
      scenario_(scenario),
      bus_(private_bus),
      recorder_(recorder),
      nonce_(nonce),
      gate_({.lab = config_.lab,
             .labs = config_.labs,
             .slack = config_.slack,
             .last_period = config_.last_period,
             .nonce = nonce,
             .can_wait = arena.info().can_wait,
             .check = [this](std::string_view lab, const LabState& state,
                             const LabState& initial) { return why_refused(lab, state, initial); }}),
      watch_(config_.lab, gate_.peers()) {
  lab_.name_ = config_.lab;
  lab_.owner_ = config_.owner;
  lab_.labs_ = config_.labs;
  lab_.arena_ = &arena_.info();
  lab_.projections_ = config_.projections;
  lab_.period_length_ = config_.period;
  lab_.seed_ = config_.seed;
  lab_.rows_ = [this](std::string_view table, std::string_view header, std::string_view values) {
    recorder_.row(table, header, values);
  };

  const auto on = [this](const std::string& pattern, hal::Bus::Handler handler) {
    subscriptions_.push_back(bus_.subscribe(pattern, std::move(handler)));
  };
  on(".*", [this](std::string_view channel, std::span<const std::byte> bytes) {
    recorder_.record(arena_.clock().now(), channel, bytes);
  });
  on(hal::channel::poses, [this, message = pose_frame_t()](std::string_view, std::span<const std::byte> bytes) mutable {
    if (!hal::decode(bytes, message)) return counters_.add("poses.refused.undecodable");
    // Parts of one frame come in order on a lab's own bus.
    if (message.part == 0)
      frame_ = hal::from_message(message);
    else
      for (const hal::Sighting& s : hal::from_message(message).robots) frame_.robots.push_back(s);
    if (message.part + 1 < message.parts) return;
    lab_.now_ = frame_.stamp;
    hash_.add(frame_);
    scenario_.on_poses(lab_, frame_);
    deliver();
  });
  on(hal::channel::to_robots,
     [this, message = to_robots_t()](std::string_view, std::span<const std::byte> bytes) mutable {
       if (!hal::decode(bytes, message)) return counters_.add("to_robots.refused.undecodable");
       arena_.robots().offer(hal::from_message(message));
     });
  const auto command = [this](std::string_view channel, std::span<const std::byte> bytes) {
    fleet_command_t message;
    if (!check_fleet_command(bytes).empty() || !hal::decode(bytes, message))
      return counters_.add("fleet_command.refused.undecodable");
    const auto decoded = hal::from_message(message);
    if (!decoded) return counters_.add("fleet_command.refused.unknown");
    if (channel != hal::channel::fleet_command) counters_.add("operator.commands");
    arena_.robots().command(*decoded);
  };
  on(hal::channel::fleet_command, command);
  on(operator_channel, command);
  on("[^/]+/world", [this](std::string_view channel, std::span<const std::byte> bytes) { hear_world(channel, bytes); });
  on("[^/]+/status", [this](std::string_view channel, std::span<const std::byte> bytes) {
    const std::string_view peer = channel.substr(0, channel.find('/'));
    watch_.hear_status(peer, gate_.nonce(peer), bytes, now_);
  });
  on(hal::channel::peers,
     [this](std::string_view, std::span<const std::byte> bytes) { watch_.hear_peers(bytes, now_); });
}

LabRun::~LabRun() = default;

// ---------------------------------------------------------------- one step

LabRun::Step LabRun::step(Now now) {
  if (phase_ == Phase::ended) return Step::ended;
  now_ = now;
  arena_.serve();
  bus_.drain();
  if (now_ >= status_due_) publish_status();
  awaits_arena_ = false;
  switch (phase_) {
    case Phase::starting:
      begin();
      phase_ = Phase::opening;
      [[fallthrough]];
    case Phase::opening:
      if (!advance(hal::LabTime{0})) return wait_for_arena();
      close_period();
      return Step::advanced;
    case Phase::running:
      if (!follow_rooms()) return wait(gate_.room_period(lab_.period_ + 1));
      return next_event() ? Step::advanced : wait_for_arena();
    case Phase::at_boundary:
      if (!gate_.may_merge(boundary_)) return wait(boundary_ > config_.slack ? boundary_ - config_.slack : 0);
      merge_period();
      return Step::advanced;
    case Phase::completing:
      if (strict() && !gate_.received_from_all(boundary_)) return wait(boundary_);
      finish();
      return Step::advanced;
    case Phase::lingering:
    case Phase::failing:
      return linger();
    case Phase::ended:
      return Step::ended;
  }
  return Step::ended;
}

void LabRun::begin() {
  const arena_info_t info = hal::to_message(arena_.info());
  bus_.publish(hal::channel::arena, info);
  lab_.declare({arena_field, 4, 0, 1'000'000'000, false, true});
  const hal::ArenaInfo& arena = arena_.info();
  lab_.publish(arena_field, {to_micro(arena.width_m), to_micro(arena.height_m),
                             static_cast<std::int64_t>(arena.robots.size()), arena.max_robot});
  scenario_.begin(lab_);
}

// The next frame or boundary, whichever is first; the calls of advance_to depend on our own configuration only. False:
// the arena is not there yet.
bool LabRun::next_event() {
  const hal::LabTime boundary = config_.period * (lab_.period_ + 1);
  const hal::LabTime frame = arena_.info().frame_period * next_frame_;
  if (!advance(std::min(frame, boundary))) return false;
  if (frame >= boundary) {
    if (moved_at_ < Now{0}) moved_at_ = now_;
    close_period();
  }
  return true;
}

bool LabRun::advance(hal::LabTime t) {
  if (!arena_.advance_to(t)) return false;
  if (auto heard = arena_.robots().heard(); !heard.empty())
    bus_.publish(hal::channel::from_robots, hal::to_message(heard, t));
  if (auto frame = arena_.poses().latest()) {
    for (const pose_frame_t& part : hal::to_messages(*frame)) bus_.publish(hal::channel::poses, part);
    bus_.drain();
  }
  if (arena_.info().frame_period * next_frame_ <= t) ++next_frame_;
  return true;
}

// An arena that computes its own time goes on at the next call; others say when.
LabRun::Step LabRun::wait_for_arena() {
  awaits_arena_ = true;
  if (const std::string wanted = arena_.waiting_for(); !wanted.empty()) set_state_text("waiting for " + wanted);
  return arena_.next_service() > hal::machine_time().now() ? Step::waiting : Step::advanced;
}

// What the scenario said, as one batch.
void LabRun::deliver() {
  if (!lab_.said_.empty()) bus_.publish(hal::channel::to_robots, hal::to_message(lab_.said_, lab_.now_, frame_.number));
  for (const hal::FleetCommand& command : lab_.commands_)
    bus_.publish(hal::channel::fleet_command, hal::to_message(command, lab_.now_));
  lab_.said_.clear();
  lab_.commands_.clear();
}

// A failure that a handler found meanwhile is never overridden.
void LabRun::enter(Phase phase) {
  if (failed_) return;
  phase_ = phase;
  waiting_since_ = now_;
}

// ---------------------------------------------------------------- boundaries

// Builds and publishes the own state of the boundary that lab time has reached.
void LabRun::close_period() {
  boundary_ = static_cast<std::uint32_t>(gate_.published() + 1);
  LabState own;
  own.period = boundary_;
  for (const hal::Sighting& s : frame_.robots) {
    hal::Pose shared = lab_.projection().to_shared(s.pose);
    // As others will decode it, so that all labs merge equal values.
    shared = {to_micro(shared.x_m) * 1e-6, to_micro(shared.y_m) * 1e-6, to_micro(shared.heading_rad) * 1e-6};
    own.robots.push_back({s.robot, shared, s.led});
  }
  for (const FieldRule& rule : lab_.rules_) {
    const auto it = lab_.fields_.find(rule.name);
    if (it == lab_.fields_.end() || (rule.initial_only && boundary_ > 0)) continue;
    own.fields.emplace(rule.name, it->second);
    if (!rule.initial_only)
      for (const std::int64_t value : it->second) hash_.add(static_cast<std::uint64_t>(value));
  }
  for (const auto& [purpose, stream] : lab_.streams_) hash_.add(stream.count());
  if (boundary_ == 0) own.settings = settings_;
  own.hash = hash_.value();
  recorder_.row("hash", "period,hash", fmt::format("{},{:016x}", boundary_, own.hash));
  gate_.publish(std::move(own));
  publish_world();
  enter(Phase::at_boundary);
}

void LabRun::merge_period() {
  const std::uint32_t k = boundary_;
  if (k == 0 && config_.require_strict && !strict())
    return fail("gate.mode is \"strict\", but an arena of this shared world cannot wait; set gate.mode = \"auto\"");
  shared_view_t view;
  const Projection& projection = lab_.projection();
  view.stamp_us = (config_.period * k).count();
  view.period = static_cast<std::int32_t>(k);
  view.shift_x_m = projection.shift_x_m, view.shift_y_m = projection.shift_y_m;
  view.turn_rad = projection.turn_rad, view.scale = projection.scale;
  for (const auto& [lab, state] : gate_.merge(k)) {
    if (k == 0) lab_.initial_states_.insert_or_assign(lab, *state);
    lab_.states_.insert_or_assign(lab, *state);
    view.labs.push_back(to_view(lab, *state, k));
  }
  view.n_labs = static_cast<std::int32_t>(view.labs.size());
  lab_.period_ = k;
  lab_.now_ = config_.period * k;
  lab_.marks_.clear();
  scenario_.on_period(lab_);
  if (k == 0) lab_.command({.kind = hal::FleetCommand::Kind::run});  // robots move once all states 0 are merged
  deliver();
  bus_.publish(hal::channel::shared, view);
  if (!lab_.marks_.empty()) bus_.publish(hal::channel::marks, hal::to_message(lab_.marks_, lab_.now_));
  if (config_.period * k % repeat_info == hal::LabTime{0})
    bus_.publish(hal::channel::arena, hal::to_message(arena_.info()));
  bus_.drain();
  recorder_.flush();
  began_period_ = now_;
  set_state_text("running");
  if (scenario_.finished(lab_)) gate_.finish_at(k);
  // In free mode the owner's end is everybody's.
  if (!strict() && config_.lab != config_.owner && gate_.done(config_.owner)) gate_.finish_at(k);
  if (k < gate_.last_period()) return enter(Phase::running);
  publish_world();  // now with `done`
  enter(Phase::completing);
}

// Free mode, arena that can wait: not ahead of the rooms; without news of any room for two periods, at real time by our
// own clock.
bool LabRun::follow_rooms() {
  if (lab_.period_ == 0 || gate_.may_begin(lab_.period_ + 1)) return true;
  return now_ - last_news_ > 2 * config_.period && now_ - began_period_ >= config_.period;
}

// ---------------------------------------------------------------- peers

void LabRun::publish_world() {
  bus_.publish(hal::channel::world, to_message(gate_.message()));
  world_due_ = now_ + repeat_world;
}

void LabRun::publish_status() {
  lab_status_t m;
  m.lab = config_.lab;
  m.nonce = static_cast<std::int64_t>(nonce_);
  m.state = state_text_;
  m.stamp_us = arena_.clock().now().count();
  m.period = static_cast<std::int32_t>(lab_.period_);
  m.last_period = static_cast<std::int32_t>(gate_.last_period());
  const double wall_s = moved_at_ < Now{0} ? 0 : static_cast<double>((now_ - moved_at_).count()) * 1e-6;
  m.speed = wall_s > 0 ? static_cast<double>(m.stamp_us) * 1e-6 / wall_s : 0;
  m.can_wait = arena_.info().can_wait;
  m.counters = hal::to_message(drops());
  for (counter_t& c : hal::to_message(lab_.counts()))
    m.counters.push_back(std::move(c)), m.counters.back().name.insert(0, "counts.");
  m.n_counters = static_cast<std::int32_t>(m.counters.size());
  bus_.publish(hal::channel::status, m);
  status_due_ = now_ + repeat_status;
}

void LabRun::hear_world(std::string_view channel, std::span<const std::byte> bytes) {
  WorldMessage message;
  if (const std::string_view why = decode_world(bytes, message); !why.empty())
    return counters_.add(fmt::format("world.refused.{}", why));
  const std::string_view origin = channel.substr(0, channel.find('/'));
  switch (gate_.hear(origin, message)) {
    case PeriodGate::Heard::counted:
      watch_.hear_state(origin, now_);
      if (!message.can_wait) last_news_ = now_;
      break;
    case PeriodGate::Heard::taught:
      publish_world();  // so that the peer learns our nonce without waiting for a repetition
      break;
    case PeriodGate::Heard::refused:
      break;
    case PeriodGate::Heard::restarted:
      if (gate_.mode() != PeriodGate::Mode::free && phase_ != Phase::lingering)
        fail(fmt::format("{} was restarted at period {}", origin, lab_.period_));
      break;
    case PeriodGate::Heard::different:
      fail(fmt::format("the labs' settings differ: {}", gate_.difference()));
      break;
  }
}

// What a peer's state can be, given its own state 0 and what the scenario declared.
std::string_view LabRun::why_refused(std::string_view lab, const LabState& state, const LabState& first) const {
  const bool initial = state.period == 0;
  for (const auto& [name, values] : state.fields) {
    const auto rule = std::find_if(lab_.rules_.begin(), lab_.rules_.end(),
                                   [&name = name](const FieldRule& r) { return r.name == name; });
    if (rule == lab_.rules_.end()) return "unknown_field";
    if (rule->owner_only && lab != config_.owner) return "not_owner";
    if (rule->initial_only && !initial) return "initial_field";
    if (values.size() != rule->length) return "field_length";
    for (const std::int64_t value : values)
      if (value < rule->low || value > rule->high) return "field_value";
  }
  const auto own = initial ? state.fields.find(arena_field) : state.fields.end();
  if (initial && own == state.fields.end()) return "no_arena";
  const std::vector<std::int64_t>& arena = first.fields.find(arena_field)->second;
  if (static_cast<std::int64_t>(state.robots.size()) > arena[2]) return "robots";
  const auto projection = config_.projections.find(lab);
  constexpr double outside_m = 0.1;  // what tracking noise and a pushed frame may add
  for (const SharedRobot& robot : state.robots) {
    if (robot.robot > arena[3]) return "robot";
    const hal::Pose at = projection->second.to_arena(robot.in_shared);
    if (!(std::abs(at.x_m) <= static_cast<double>(arena[0]) * 5e-7 + outside_m) ||
        !(std::abs(at.y_m) <= static_cast<double>(arena[1]) * 5e-7 + outside_m))
      return "position";
  }
  return {};
}

// Repeats what peers need and tells the dead from the cut off. `wanted`: the period of the peers' states that is waited
// for.
LabRun::Step LabRun::wait(std::uint32_t wanted) {
  if (now_ >= world_due_) publish_world();
  for (const std::string& peer : gate_.peers()) {
    if (gate_.received(peer) >= static_cast<std::int64_t>(wanted)) continue;
    const bool bound = gate_.bound(peer);
    const std::string words = watch_.words(peer, bound, now_);
    switch (watch_.life(peer, bound, now_)) {
      case PeerMonitor::Life::failed:
      case PeerMonitor::Life::dead:
        fail(fmt::format("{} is gone at period {}: {}", peer, lab_.period_, words));
        return Step::advanced;
      case PeerMonitor::Life::link_down:
      case PeerMonitor::Life::gateway_silent:
        if (now_ - waiting_since_ > config_.patience) {
          fail(fmt::format("gave up waiting for {} after {} s: {}", peer, config_.patience.count() / 1'000'000, words));
          return Step::advanced;
        }
        break;
      case PeerMonitor::Life::unknown:
      case PeerMonitor::Life::alive:
        break;
    }
    set_state_text(fmt::format("waiting for {}: {}", peer, words));
    break;
  }
  return Step::waiting;
}

// ---------------------------------------------------------------- ending

void LabRun::fail(std::string_view why) {
  if (failed_ || phase_ == Phase::ended) return;
  reason_ = why;
  set_state_text("failed: " + reason_);
  enter(Phase::failing);
  failed_ = true;
  linger_until_ = now_ + fail_linger;
  publish_status();
  recorder_.flush();
}

void LabRun::stop(std::string_view why) {
  fail(hal::stopped(why, arena_));
}

void LabRun::finish() {
  set_state_text("finished");
  enter(Phase::lingering);
  linger_until_ = now_ + linger_most;
  publish_world();
  publish_status();
  bus_.drain();
  recorder_.flush();
}

// Repeats the last state until every peer has it, or is gone; a failed run repeats its status for a moment.
LabRun::Step LabRun::linger() {
  if (now_ >= world_due_) publish_world(), bus_.drain();
  bool over = now_ >= linger_until_;
  if (phase_ == Phase::lingering) {
    const bool all = std::all_of(gate_.peers().begin(), gate_.peers().end(), [&](const std::string& peer) {
      const auto life = watch_.life(peer, gate_.bound(peer), now_);
      return gate_.acknowledged(peer, boundary_) || life == PeerMonitor::Life::dead ||
             life == PeerMonitor::Life::failed || (!strict() && gate_.done(peer));
    });
    if (over) counters_.add("gate.linger_gave_up");
    if (!all)
      acknowledged_at_ = Now{-1};
    else if (acknowledged_at_ < Now{0})
      acknowledged_at_ = now_;
    over = over || (all && (gate_.peers().empty() || now_ - acknowledged_at_ >= linger_more));
  }
  if (!over) return Step::waiting;
  phase_ = Phase::ended;
  return Step::ended;
}

void LabRun::set_state_text(std::string text) {
  state_text_ = std::move(text);
}

std::map<std::string, std::uint64_t> LabRun::hash_by_lab() const {
  std::map<std::string, std::uint64_t> hashes;
  for (const std::string& peer : gate_.peers()) hashes[peer] = gate_.newest(peer) ? gate_.newest(peer)->hash : 0;
  hashes[config_.lab] = hash_.value();
  return hashes;
}

std::uint64_t LabRun::final_hash() const {
  BehaviourHash all;
  for (const auto& [lab, hash] : hash_by_lab()) all.add(hash);
  return all.value();
}

hal::Counters LabRun::drops() const {
  hal::Counters all = counters_;
  all.merge(gate_.counters());
  all.merge(watch_.counters());
  all.merge(arena_.counters(), "arena.");
  all.merge(recorder_.counters());
  all.merge(bus_.counters(), "bus.");
  const hal::Airtime air = arena_.robots().airtime();
  all.set("to_robots.offered", air.offered);
  all.set("to_robots.sent", air.sent);
  all.set("to_robots.replaced", air.replaced);
  all.set("to_robots.refused", air.refused);
  all.set("to_robots.not_sent", air.not_sent);
  return all;
}

}  // namespace arkmesh::lab
