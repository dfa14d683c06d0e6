// Two ends and two lanes per pair of labs. What is offered while the link is down waits in an outbox, as with a real
// link.
#include "gateway/links/loopback.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <deque>
#include <utility>
#include <vector>

#include "gateway/frame/frame.hpp"
#include "gateway/outbox/outbox.hpp"
#include "hal/random.hpp"

namespace arkmesh::gateway {

namespace {

constexpr std::size_t outbox_bytes = 4 << 20;

using SharedBytes = std::shared_ptr<const std::vector<std::byte>>;

struct Travelling {
  std::uint64_t due = 0;  // step
  std::string channel;
  SharedBytes bytes;
};

// What a network and its ends share.
struct Common {
  std::uint64_t now = 0;  // steps
  bool still = false;     // nothing is under way, and each link is as it stays until somebody does something
  SharedBytes newest;     // sent: a lab sends most messages to each peer

  SharedBytes keep(std::span<const std::byte> bytes) {
    const bool same = newest && newest->size() == bytes.size() &&
                      (bytes.empty() || std::memcmp(newest->data(), bytes.data(), bytes.size()) == 0);
    if (!same) newest = std::make_shared<const std::vector<std::byte>>(bytes.begin(), bytes.end());
    return newest;
  }
};

// One direction, as its sender holds it.
struct Lane {
  Lane(std::uint64_t seed, const std::string& name, std::uint64_t number) : random(seed, name, number) {}
  hal::RandomStream random;
  std::deque<Travelling> under_way;  // ascending `due`
  Outbox outbox{outbox_bytes};
};

// One end of a pair. The link object and the network both hold it; whichever dies first leaves it to the other.
struct End {
  std::string lab, peer;
  std::uint64_t number;  // counts the ends of the pair; stands for the boot id
  Link::Events events;
  LinkStats stats;
  bool started = false, stopped = false;
  Lane lane;  // towards the peer; sends only while up
  LoopbackImpairment* impairment = nullptr;
  std::shared_ptr<Common> common;

  End(std::string from, std::string to, std::uint64_t seed, std::uint64_t number_in_pair)
      : lab(std::move(from)),
        peer(std::move(to)),
        number(number_in_pair),
        lane(seed, "loopback/" + lab + ">" + peer, number_in_pair) {}

  void change(bool up, std::string_view why) {
    if (!started || stopped || (stats.up == up && stats.why == why)) return;
    stats.up = up;
    stats.why = why;
    if (const auto tell = events.changed) tell(up, why);
  }

  void send(std::string_view channel, std::span<const std::byte> bytes) {
    if (impairment->loss > 0 && lane.random.uniform() < impairment->loss) {
      stats.counters.add("lost.by_impairment");
      return;
    }
    ++stats.sent_messages;
    stats.sent_bytes += bytes.size();
    common->still = false;
    std::uint64_t due = common->now + 1 + impairment->delay_steps;
    if (impairment->jitter_steps > 0) due += lane.random.below(impairment->jitter_steps + 1ULL);
    if (!lane.under_way.empty()) due = std::max(due, lane.under_way.back().due);
    Travelling message{due, std::string(channel), common->keep(bytes)};
    if (impairment->repeat > 0 && lane.random.uniform() < impairment->repeat) {
      stats.counters.add("repeated.by_impairment");
      lane.under_way.push_back(message);
    }
    lane.under_way.push_back(std::move(message));
  }

  void lose_what_is_under_way() {
    if (!lane.under_way.empty()) stats.counters.add("lost.link_down", lane.under_way.size());
    lane.under_way.clear();
  }

  void empty_outbox() {
    for (auto frames = lane.outbox.whole_message({}); !frames.empty(); frames = lane.outbox.whole_message({})) {
      const auto message = decode_message(frames);
      send(message->channel, message->bytes);
      lane.outbox.acknowledged(lane.outbox.written(frames.size()).messages);
    }
  }
};

// The two ends between two labs, as far as they were made. A stopped end is followed by a new one in its place.
struct Pair {
  std::string first, second;  // ascending
  std::shared_ptr<End> of_first, of_second;
  LoopbackImpairment impairment;
  bool cable = true;       // what set_up() says
  std::uint64_t ends = 0;  // made so far

  std::shared_ptr<End>& end_of(const std::string& lab) { return lab == first ? of_first : of_second; }
  bool can_be_up() const {
    const auto lives = [](const auto& end) { return end && end->started && !end->stopped; };
    return cable && lives(of_first) && lives(of_second);
  }
  bool any_up() const { return (of_first && of_first->stats.up) || (of_second && of_second->stats.up); }

  void take_down(std::string_view why) {
    for (const auto& end : {of_first, of_second}) {
      if (!end) continue;
      end->lose_what_is_under_way();
      end->change(false, why);
    }
  }
  void bring_up() {
    of_first->stats.peer_boot_id = of_second->number;
    of_second->stats.peer_boot_id = of_first->number;
    of_first->stats.peer_version = of_second->stats.peer_version = ARKMESH_VERSION;
    for (const auto& end : {of_first, of_second}) end->change(true, "connected");
    for (const auto& end : {of_first, of_second}) end->empty_outbox();
  }
};

}  // namespace

struct LoopbackNetwork::State {
  std::uint64_t seed = 0;
  std::shared_ptr<Common> common = std::make_shared<Common>();
  std::deque<Pair> pairs;  // in the order of their making; a deque, because ends point into it

  Pair& pair(const std::string& a, const std::string& b) {
    assert(a != b && "a lab is not its own peer");
    const auto [first, second] = std::minmax(a, b);
    for (Pair& pair : pairs)
      if (pair.first == first && pair.second == second) return pair;
    Pair& made = pairs.emplace_back();
    made.first = first;
    made.second = second;
    return made;
  }

  int deliver(End& from, End& to) {
    int delivered = 0;
    while (!to.stopped && !from.lane.under_way.empty() && from.lane.under_way.front().due <= common->now) {
      const Travelling message = std::move(from.lane.under_way.front());
      from.lane.under_way.pop_front();
      ++to.stats.received_messages;
      to.stats.received_bytes += message.bytes->size();
      ++delivered;
      if (const auto tell = to.events.arrived) tell(message.channel, *message.bytes);
    }
    return delivered;
  }
};

namespace {

class LoopbackLink final : public Link {
 public:
  explicit LoopbackLink(std::shared_ptr<End> end) : end_(std::move(end)) {}
  ~LoopbackLink() override { stop(); }

  const std::string& peer() const override { return end_->peer; }

  void start(Events events) override {
    end_->events = std::move(events);
    end_->started = true;
    end_->common->still = false;
  }

  void offer(const Rule& rule, std::string_view channel, std::span<const std::byte> bytes) override {
    if (end_->stopped) return;
    if (end_->stats.up)
      end_->send(channel, bytes);
    else
      end_->lane.outbox.put({std::string(channel), rule.delivery}, bytes, {});
  }

  void keep_only(const Passes& passes) override { end_->lane.outbox.keep_only(passes); }

  LinkStats stats() const override {
    LinkStats stats = end_->stats;
    stats.counters.merge(end_->lane.outbox.counters());
    return stats;
  }

  void stop() override {
    end_->stopped = true;
    end_->stats.up = false;
    end_->stats.why = "stopped";
    end_->events = {};
    end_->common->still = false;
  }

 private:
  std::shared_ptr<End> end_;  // shared with the network
};

}  // namespace

LoopbackNetwork::LoopbackNetwork(std::uint64_t seed) : state_(std::make_shared<State>()) {
  state_->seed = seed;
}
LoopbackNetwork::~LoopbackNetwork() = default;

std::unique_ptr<Link> LoopbackNetwork::end(const std::string& lab, const std::string& peer) {
  Pair& pair = state_->pair(lab, peer);
  std::shared_ptr<End>& place = pair.end_of(lab);
  assert((!place || place->stopped) && "this end is held by a living link");
  if (pair.any_up()) pair.take_down("peer stopped");
  place = std::make_shared<End>(lab, peer, state_->seed, ++pair.ends);
  place->impairment = &pair.impairment;
  place->common = state_->common;
  state_->common->still = false;
  return std::make_unique<LoopbackLink>(place);
}

void LoopbackNetwork::impair(const std::string& a, const std::string& b, LoopbackImpairment impairment) {
  state_->pair(a, b).impairment = impairment;
}

void LoopbackNetwork::set_up(const std::string& a, const std::string& b, bool up) {
  Pair& pair = state_->pair(a, b);
  pair.cable = up;
  state_->common->still = false;
  // Up again at the next step, together with what becomes due then.
  if (!up) pair.take_down("link down");
}

int LoopbackNetwork::step() {
  const auto state = state_;  // a handler may end the network
  ++state->common->now;
  if (std::exchange(state->common->still, true)) return 0;
  int delivered = 0;
  for (Pair& pair : state->pairs) {
    if (pair.any_up() && !pair.can_be_up()) pair.take_down("peer stopped");
    if (!pair.can_be_up()) continue;
    if (!pair.any_up()) pair.bring_up();
    // A handler may end an end.
    const auto first = pair.of_first, second = pair.of_second;
    delivered += state->deliver(*first, *second);
    delivered += state->deliver(*second, *first);
    if (!first->lane.under_way.empty() || !second->lane.under_way.empty()) state->common->still = false;
  }
  return delivered;
}

bool LoopbackNetwork::busy() const {
  for (const Pair& pair : state_->pairs)
    for (const auto& end : {pair.of_first, pair.of_second})
      if (end && !end->lane.under_way.empty()) return true;
  return false;
}

}  // namespace arkmesh::gateway
