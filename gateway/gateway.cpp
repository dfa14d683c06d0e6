// Bus -> links by one subscription, links -> bus under the peer's name, and the books about both.
#include "gateway/gateway.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "arkmesh/peers_t.hpp"
#include "gateway/frame/channel_name.hpp"
#include "gateway/outbox/budget.hpp"
#include "hal/arenas/messages.hpp"

namespace arkmesh::gateway {

namespace {

using Now = std::chrono::microseconds;
constexpr Now publish_period{1'000'000};
// A peer that names more channels is not one of ours; bounds what it can make us remember.
constexpr std::size_t max_channels = 256, max_refused_channels = 16;

// What one peer has sent on one channel.
struct Received {
  std::int64_t messages = 0, bytes = 0;
  bool fresh = false;  // came since the last tick
  Now last{0};         // the first tick after the newest message
  int rules = -1;      // whose limits these are
  Budget of_messages, of_bytes;
};

struct Peer {
  Link* link = nullptr;
  std::map<std::string, Received, std::less<>> channels;  // by name on this lab's bus
  hal::Counters refused;                                  // by channel, as far as there are not too many
  Budget of_messages, of_bytes;                           // of all channels together
};

Budget budget(double per_s) {
  return Budget(std::isnan(per_s) ? Budget::unlimited : per_s);
}

}  // namespace

struct Gateway::State {
  hal::Bus& bus;
  std::string lab;
  std::uint64_t boot_id;
  ChannelRules rules;
  std::vector<std::unique_ptr<Link>> links;
  std::vector<Peer> peers;  // as links
  std::unique_ptr<hal::Bus::Subscription> subscription;
  // Channels of this bus that some peer gets, and how each does.
  std::map<std::string, std::vector<std::optional<Rule>>, std::less<>> ways;
  hal::Counters counters;
  bool changed = true;
  std::optional<Now> published;
  Now time{0};           // of the newest tick
  bool heard = false;    // something came since then
  int rules_number = 0;  // grows with each change of the rules

  // How a channel of this bus goes to each peer.
  std::vector<std::optional<Rule>> ways_of(std::string_view channel) const {
    std::vector<std::optional<Rule>> each(links.size());
    for (std::size_t i = 0; i < links.size(); ++i)
      if (const ChannelRule* rule = rules.passing(Direction::exports, channel, links[i]->peer()))
        each[i] = rule->on_link(std::string(channel));
    return each;
  }
  static bool lead_nowhere(const std::vector<std::optional<Rule>>& each) {
    return std::ranges::none_of(each, [](const auto& way) { return way.has_value(); });
  }

  void use(ChannelRules new_rules) {
    rules = std::move(new_rules);
    ++rules_number;
    for (auto& [channel, each] : ways) each = ways_of(channel);
    std::erase_if(ways, [](const auto& way) { return lead_nowhere(way.second); });
    for (std::size_t i = 0; i < links.size(); ++i) {
      // What was heard so far may wait for peers.
      links[i]->keep_only([this, i](std::string_view channel) {
        const auto way = ways.find(channel);
        return way != ways.end() && way->second[i];
      });
      const PeerLimits limits = rules.limits_of(links[i]->peer());
      peers[i].of_messages = budget(limits.rate_hz);
      peers[i].of_bytes = budget(limits.bytes_per_s);
    }
    subscription.reset();
    if (const std::string pattern = rules.bus_pattern(); !pattern.empty())
      subscription = bus.subscribe(pattern, [this](std::string_view channel, std::span<const std::byte> bytes) {
        export_to_peers(channel, bytes);
      });
  }

  void export_to_peers(std::string_view channel, std::span<const std::byte> bytes) {
    auto found = ways.find(channel);
    if (found == ways.end()) {
      if (!is_exported_name(channel)) return counters.add("sent.refused.channel_name");
      auto each = ways_of(channel);
      if (lead_nowhere(each)) return;
      if (ways.size() == max_channels) return counters.add("sent.refused.too_many_channels");
      found = ways.emplace(channel, std::move(each)).first;
    }
    for (std::size_t i = 0; i < links.size(); ++i)
      if (const std::optional<Rule>& way = found->second[i]) links[i]->offer(*way, way->channel, bytes);
  }

  void arrived(Peer& peer, std::string_view channel, std::span<const std::byte> bytes) {
    if (!is_exported_name(channel)) return counters.add("received.refused.channel_name");
    const ChannelRule* const rule = rules.passing(Direction::imports, channel, peer.link->peer());
    if (!rule) return refuse(peer, "not_imported", channel);
    std::string name = foreign_name(peer.link->peer(), channel);
    auto received = peer.channels.find(name);
    if (received == peer.channels.end()) {
      if (peer.channels.size() == max_channels) return counters.add("received.refused.too_many_channels");
      received = peer.channels.emplace(name, Received{}).first;
    }
    if (std::exchange(received->second.rules, rules_number) != rules_number) {
      received->second.of_messages = budget(rule->rate_hz);
      received->second.of_bytes = budget(rule->bytes_per_s);
    }
    if (const char* reason = over_limit(peer, received->second, bytes.size())) return refuse(peer, reason, channel);
    ++received->second.messages;
    received->second.bytes += static_cast<std::int64_t>(bytes.size());
    received->second.fresh = heard = true;
    bus.publish(name, bytes);
  }

  // Why a message is one too many; null when it is not.
  const char* over_limit(Peer& peer, Received& channel, std::size_t size) const {
    const auto bytes = static_cast<double>(size);
    if (!channel.of_messages.has(1, time)) return "rate_limited";
    if (!channel.of_bytes.has(bytes, time)) return "over_budget";
    if (!peer.of_messages.has(1, time)) return "peer_rate_limited";
    if (!peer.of_bytes.has(bytes, time)) return "peer_over_budget";
    for (Budget* budget : {&channel.of_messages, &peer.of_messages}) budget->use(1);
    for (Budget* budget : {&channel.of_bytes, &peer.of_bytes}) budget->use(bytes);
    return nullptr;
  }

  static void refuse(Peer& peer, std::string_view reason, std::string_view channel) {
    const std::string all = fmt::format("received.refused.{}", reason);
    const std::string counter = fmt::format("{}.{}", all, channel);
    peer.refused.add(peer.refused[counter] == 0 && peer.refused.all().size() >= max_refused_channels ? all : counter);
  }

  peer_t describe(const Peer& peer, Now now) const {
    const LinkStats stats = peer.link->stats();
    peer_t out;
    out.lab = peer.link->peer();
    out.up = stats.up;
    out.why = stats.why;
    out.boot_id = static_cast<std::int64_t>(stats.peer_boot_id);
    out.version = stats.peer_version;
    out.round_trip_us = -1;
    out.clock_offset_us = out.clock_uncertainty_us = 0;
    out.clock_drift_ppm = 0;
    if (const auto& clock = stats.clock) {
      out.round_trip_us = clock->round_trip_us;
      out.clock_offset_us = stats.peer_wall_offset_us;
      out.clock_uncertainty_us = clock->uncertainty_us;
    }
    for (const auto& [name, received] : peer.channels) {
      channel_age_t& age = out.channels.emplace_back();
      age.channel = name;
      age.age_us = (now - received.last).count();
      age.messages = received.messages;
      age.bytes = received.bytes;
    }
    out.n_channels = static_cast<std::int32_t>(out.channels.size());
    hal::Counters all = stats.counters;
    all.merge(peer.refused);
    all.set("received.bytes", stats.received_bytes);
    all.set("received.messages", stats.received_messages);
    all.set("sent.bytes", stats.sent_bytes);
    all.set("sent.messages", stats.sent_messages);
    out.counters = hal::to_message(all);
    out.n_counters = static_cast<std::int32_t>(out.counters.size());
    return out;
  }
};

Gateway::Gateway(hal::Bus& bus, std::string lab, std::uint64_t boot_id, ChannelRules rules,
                 std::vector<std::unique_ptr<Link>> links)
    : state_(new State{bus, std::move(lab), boot_id, {}, std::move(links), {}, {}, {}, {}, true, {}, {}}) {
  assert(boot_id != 0 && "0 stands for a peer that was never met");
  state_->peers.resize(state_->links.size());
  for (std::size_t i = 0; i < state_->links.size(); ++i) state_->peers[i].link = state_->links[i].get();
  state_->use(std::move(rules));
}

void Gateway::set_rules(ChannelRules rules) {
  state_->use(std::move(rules));
}

void Gateway::start() {
  for (Peer& peer : state_->peers) {
    Link::Events events;
    events.arrived = [state = state_.get(), &peer](std::string_view channel, std::span<const std::byte> bytes) {
      state->arrived(peer, channel, bytes);
    };
    events.changed = [state = state_.get()](bool, std::string_view) { state->changed = true; };
    peer.link->start(std::move(events));
  }
}

Gateway::~Gateway() {
  for (const auto& link : state_->links) link->stop();
}

bool Gateway::tick(Now now, const hal::Counters& more) {
  state_->time = now;
  if (std::exchange(state_->heard, false))
    for (Peer& peer : state_->peers)
      for (auto& [name, received] : peer.channels)
        if (std::exchange(received.fresh, false)) received.last = now;
  if (!state_->changed && state_->published && now - *state_->published < publish_period) return false;
  state_->changed = false;
  state_->published = now;
  state_->bus.publish(hal::channel::peers, describe(now, more));
  return true;
}

peers_t Gateway::describe(Now now, const hal::Counters& more) const {
  peers_t message;
  message.lab = state_->lab;
  message.boot_id = static_cast<std::int64_t>(state_->boot_id);
  for (const Peer& peer : state_->peers) message.peers.push_back(state_->describe(peer, now));
  message.n_peers = static_cast<std::int32_t>(message.peers.size());
  hal::Counters all = state_->counters;
  all.merge(state_->bus.counters(), "bus.");
  all.merge(more);
  message.counters = hal::to_message(all);
  message.n_counters = static_cast<std::int32_t>(message.counters.size());
  return message;
}

void Gateway::announce() {
  state_->changed = true;
}

const std::vector<std::unique_ptr<Link>>& Gateway::links() const {
  return state_->links;
}

const hal::Counters& Gateway::counters() const {
  return state_->counters;
}

}  // namespace arkmesh::gateway
