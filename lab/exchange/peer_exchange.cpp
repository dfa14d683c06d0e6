#include "lab/exchange/peer_exchange.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "hal/arenas/messages.hpp"

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr PeerExchange::Now repeat_world_after = 50ms;

std::string_view origin_of(std::string_view channel) {
  return channel.substr(0, channel.find('/'));
}

}  // namespace

PeerExchange::PeerExchange(const RunConfig& config, const hal::ArenaInfo& arena, std::uint64_t run_id,
                           hal::Bus& private_bus, std::shared_ptr<WorldReader> worlds)
    : lab_(config.lab),
      owner_(config.owner),
      exchange_(config.exchange),
      by_events_(config.exchange.by_events(config.lab == config.owner)),
      with_labs_(arena.starts_with_labs),
      period_length_(config.period),
      max_message_bytes_(config.max_message_bytes),
      bus_(private_bus),
      worlds_(std::move(worlds)),
      gate_({.lab = config.lab,
             .labs = config.labs,
             .slack = config.slack,
             .last_period = config.last_period,
             .run_id = run_id,
             .can_wait = arena.can_wait,
             .exchange = config.exchange,
             .until_confirmed = by_events_ && config.exchange.mode == Exchange::Mode::mixed}),
      peers_(config, arena.can_wait, gate_),
      events_(config.exchange.confirmed_within(config.slack)) {
  subscriptions_.push_back(
      bus_.subscribe("[^/]+/(world|status)", [this](std::string_view channel, std::span<const std::byte> bytes) {
        const std::string_view peer = origin_of(channel);
        const bool accepted = channel.ends_with("/world") ? hear_world(peer, bytes) : peers_.hear_status(peer, bytes);
        if (recording_) recording_(channel, bytes, accepted);
      }));
  subscriptions_.push_back(bus_.subscribe(hal::channel::peers, [this](std::string_view channel, auto bytes) {
    const bool accepted = peers_.hear_peers(bytes);
    if (recording_) recording_(channel, bytes, accepted);
  }));
}

bool PeerExchange::hear_world(std::string_view origin, std::span<const std::byte> bytes) {
  std::string_view why;
  const std::shared_ptr<const WorldMessage> message = worlds_->read(origin, bytes, why);
  if (!message) {
    peers_.note_refused(origin, fmt::format("its message is ill-formed ({})", why));
    counters_.add(fmt::format("world.refused.{}", why));
    return false;
  }
  if (gate_.knows(origin)) tally_.heard(origin, *message, bytes.size());
  const std::uint64_t before = strict() ? 0 : gate_.run_id(origin);  // strict labs go on with no other run
  switch (gate_.hear(origin, message)) {
    case PeriodGate::Heard::counted:
      peers_.note_counted(origin);
      if (before != 0 && before != gate_.run_id(origin))
        spdlog::warn("{} was restarted at period {} of {}: its new run counts from now on", origin, peers_.period(),
                     lab_);
      if (!message->can_wait) last_state_ = peers_.now();
      if (growth_) growth_->hear(origin, origin == owner_, message->run_id, message->growth);
      return true;
    case PeriodGate::Heard::taught:
      owe_answer(origin);
      break;
    case PeriodGate::Heard::refused:
      if (gate_.published() >= 0) peers_.note_refused(origin, gate_.newest_refusal());
      break;
    case PeriodGate::Heard::restarted:
      if (!complete_ && failure_.empty())
        failure_ = fmt::format("{} was restarted at period {}", origin, peers_.period());
      break;
    case PeriodGate::Heard::different:
      if (failure_.empty()) failure_ = fmt::format("the labs' settings differ: {}", gate_.difference());
      break;
  }
  return false;
}

// A peer that does not know our run id learns it without waiting for a repetition. It is answered once a period, so
// that its few bytes cannot call up our whole state as often as it likes.
void PeerExchange::owe_answer(std::string_view peer) {
  const auto answered = answered_.find(peer);
  if (answered != answered_.end() && peers_.now() - answered->second < period_length_)
    return counters_.add("world.answered_before");
  answered_.insert_or_assign(std::string(peer), peers_.now());
  owes_answer_ = true;
}

bool PeerExchange::answer() {
  if (!std::exchange(owes_answer_, false)) return false;
  publish_world();
  return true;
}

void PeerExchange::publish(LabState own) {
  if (by_events_) {
    if (exchange_.mode == Exchange::Mode::event) events_.shown(gate_.acknowledged());
    events_.published(own.period, own.period > 0 && !own.made_at && !gate_.peers().empty());
  }
  gate_.publish(std::move(own));
  peers_.note_published();
  publish_world();
}

void PeerExchange::publish_early(LabState event) {
  gate_.publish_early(std::move(event));
  tally_.told_early();
  publish_world();
}

// By event: peers have received it. Mixed: the owner has merged it and says so.
void PeerExchange::note_confirmed(const std::vector<MergedState>& merged) {
  if (exchange_.mode == Exchange::Mode::event) return events_.shown(gate_.acknowledged());
  const auto owner = std::ranges::find(merged, owner_, &MergedState::lab);
  const auto own = std::ranges::find(merged, lab_, &MergedState::lab) - merged.begin();
  if (owner == merged.end()) return;
  const auto applied = owner->state->fields.find(applied_rule(merged.size()).name);
  if (applied == owner->state->fields.end() || applied->second.size() != merged.size()) return;
  const std::int64_t shown = applied->second[static_cast<std::size_t>(own)];
  events_.shown(shown);
  gate_.confirm(shown);
}

std::vector<MergedState> PeerExchange::merge(std::uint32_t k) {
  merged_ = peers_.now();
  auto merged = gate_.merge(k);
  peers_.note_merged(k, merged);
  if (k > 0) tally_.applied(merged, lab_, owner_, exchange_);
  if (by_events_) note_confirmed(merged);
  return merged;
}

bool PeerExchange::may_merge(std::uint32_t k) const {
  if (!gate_.may_merge(k)) return false;
  if (with_labs_ && !strict()) return !peers_.awaits(k);
  if (gate_.has_real_time_states(k)) return true;
  return peers_.now() - last_state_ > 2 * period_length_ && peers_.now() - merged_ >= period_length_;
}

void PeerExchange::publish_world() {
  WorldMessage world = gate_.message();
  if (growth_) world.growth = growth_->told();
  world_t message = to_message(world);
  auto bytes = static_cast<std::size_t>(message.getEncodedSize());
  if (bytes > max_message_bytes_ && !world.growth.empty()) {
    counters_.add("growth.too_long");
    world.growth.clear();
    message = to_message(world);
    bytes = static_cast<std::size_t>(message.getEncodedSize());
  }
  tally_.sent(world, bytes);
  if (bytes > max_message_bytes_ && !gate_.peers().empty() && failure_.empty())
    failure_ = fmt::format(
        "the message of {} to its peers has {} bytes at period {}, and gateway.max_message_bytes = {}: raise that in "
        "all labs, or use fewer robots",
        lab_, bytes, gate_.published(), max_message_bytes_);
  bus_.publish(hal::channel::world, message);
  world_due_ = peers_.now() + repeat_world_after;
}

bool PeerExchange::repeat_world() {
  if (peers_.now() < world_due_) return false;
  publish_world();
  return true;
}

void PeerExchange::linger_after_last_period() {
  complete_ = true;
  peers_.linger_after_last_period();
  publish_world();
}

std::map<std::string, std::uint64_t> PeerExchange::hash_by_lab(std::uint64_t own) const {
  std::map<std::string, std::uint64_t> hashes{{lab_, own}};
  for (const std::string& peer : gate_.peers()) {
    const LabState* newest = gate_.newest(peer);
    hashes[peer] = newest ? newest->hash : 0;
  }
  return hashes;
}

nlohmann::json PeerExchange::exchange_figures() const {
  return tally_.json(exchange_, events_);
}

hal::Counters PeerExchange::counters() const {
  hal::Counters all = counters_;
  all.merge(gate_.counters());
  all.merge(peers_.counters());
  if (events_.unconfirmed() > 0) all.set("exchange.unconfirmed", events_.unconfirmed());
  if (events_.resent() > 0) all.set("exchange.resent", events_.resent());
  return all;
}

}  // namespace arkmesh::lab
