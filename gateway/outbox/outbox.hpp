// What is to be sent to one peer, bounded in bytes, until the peer has acknowledged it. Decides what goes next, what is
// replaced and what is dropped when the peer is slow or away; never talks to anybody itself. The books balance for each
// channel: accepted = acknowledged + in flight + queued + replaced + dropped + lost with a session + refused.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/link.hpp"
#include "hal/counters.hpp"

namespace arkmesh::gateway {

class Outbox {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // What one message costs beside its own bytes: list node, map entry, allocator. Counted against the limit.
  static constexpr std::size_t overhead_bytes = 192;

  explicit Outbox(std::size_t limit_bytes) : limit_(limit_bytes) {}
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  // Takes a message of rule.channel. `latest`: replaces a waiting one of the same channel, in its place in the queue.
  // What the rule lets go only later is held back. When there is no room the oldest `ordered` ones go first, then the
  // oldest `latest` ones; all counted. False when it was refused: too long, or all room is taken by what is in flight.
  bool put(const Rule& rule, std::span<const std::byte> bytes, Time now);

  // Longer messages are refused from now on; those that wait are dropped. All counted.
  void set_longest(std::size_t message_bytes);

  // Channels that do not pass any more send nothing: what waits of them, or comes back with a lost session, is dropped,
  // and counted. Until the next put().
  void keep_only(const Link::Passes& passes);

  // The next frames to write, at most `max_frames`, and at most `max_bytes` unless the first alone is larger; nothing
  // when that is 0. Messages of one frame go before longer ones, frame by frame, which yet get half of the bytes; in
  // one channel all keep their order. They are in flight from now on, and stay valid until they are written and
  // acknowledged, or the session is lost.
  std::vector<std::span<const std::byte>> batch(std::size_t max_frames, std::size_t max_bytes, Time now);
  // The next message with all its frames, as encode_message() made it; nothing when none waits. For links that carry
  // messages, not bytes; not beside batch().
  std::span<const std::byte> whole_message(Time now);
  // When a message that is held back may go; nothing when none is, or others of its channel go first.
  std::optional<Time> next_release() const;
  // So many more bytes of what was handed out have been written. Returns which messages are complete by that.
  struct Sent {
    std::size_t messages = 0;
    std::size_t bytes = 0;  // of these messages, as they were put
  };
  Sent written(std::size_t bytes);
  // The peer has so many more of the messages that were written, in the order of their last frames. False when they
  // were not written.
  bool acknowledged(std::size_t messages);
  // What was in flight may not have arrived: `ordered` messages wait again, before all others, `latest` ones are lost.
  void session_lost();
  // A new session: of each `latest` channel where nothing newer waits, the newest message that was lost with the last
  // session is accepted once more; and that which arrived, for a peer that was started again and has nothing. Both are
  // kept for this as long as there is room.
  void send_again(bool also_what_arrived);

  std::size_t waiting_messages() const;
  bool empty() const { return waiting_messages() + leaving_.size() + in_flight_.size() == 0; }
  // All that is held, including overhead; never above the limit.
  std::size_t bytes() const { return bytes_; }
  // `ordered` messages since the beginning; those of them that are not acknowledged or dropped.
  std::uint64_t ordered_accepted() const { return ordered_accepted_; }
  std::uint64_t ordered_pending() const { return ordered_pending_; }
  // outbox.WHAT.<channel>: accepted, acknowledged, in_flight, queued, replaced, dropped.full, dropped.session_lost,
  // dropped.rate_limited, dropped.over_budget, dropped.denied, refused.too_big. And outbox.waiting.messages,
  // outbox.waiting.bytes.
  hal::Counters counters() const;

 private:
  enum Lane : std::size_t { of_short, of_long, lanes, held_back = lanes };
  struct Channel;
  struct Entry {
    Channel* channel = nullptr;  // node of channels_, which never moves
    Delivery delivery = Delivery::latest;
    Lane lane = held_back;
    std::uint64_t number = 0;            // of arrival
    std::size_t message_bytes = 0;       // as it was put
    std::vector<std::byte> frames = {};  // as it goes on the byte stream
    std::size_t handed_out = 0;          // bytes of these
    std::uint64_t end = 0;               // what had been handed out in all with the last of them
  };
  using Entries = std::list<Entry>;
  struct Channel {
    Rule rule;                // of the newest message
    Entries held;             // held back, oldest first
    Time next = {};           // the next may go
    bool over_bytes = false;  // because of bytes_per_s rather than rate_hz
    bool denied = false;
    Entries::iterator waiting;  // the `latest` entry that a newer one replaces
    bool has_waiting = false;
    std::size_t long_ones = 0;  // entries in the lane of longer messages
    std::uint64_t sequence = 0;
    std::vector<std::byte> newest;  // of `latest`, that went out last
    std::size_t newest_bytes = 0;   // as it was put
    bool newest_arrived = false;    // it was acknowledged
    std::uint64_t accepted = 0, acknowledged = 0, in_flight = 0, queued = 0;
    std::uint64_t replaced = 0, dropped = 0, refused = 0, lost = 0;
    std::uint64_t rate_limited = 0, over_budget = 0, denials = 0;

    bool is_paced() const { return rule.rate_hz != Rule::unlimited || rule.bytes_per_s != Rule::unlimited; }
    bool is_in_lane() const { return queued > held.size(); }
    bool may_go(Time now) const { return !is_paced() || (!is_in_lane() && now >= next); }
  };
  // What a message goes later than it might is made up for by the next ones, up to so much.
  static constexpr std::chrono::milliseconds catch_up{10};

  static std::size_t cost(const Entry& entry) { return entry.frames.capacity() + overhead_bytes; }
  Channel& channel(std::string_view name);
  void enqueue(Entries& from, Entries::iterator entry);
  void erase(Entries& from, Entries::iterator entry);
  void forget_newest(Channel& of);
  void keep_newest(Entries& from, Entries::iterator entry, bool arrived);
  template <class Condition>
  void drop_waiting(Condition condition, std::uint64_t Channel::*reason);
  bool make_room(std::size_t wanted);
  std::span<const std::byte> hand_out(Lane from, std::size_t bytes, Time now);
  static void pace(Channel& of, std::size_t bytes, Time now);
  bool drop_oldest(Delivery victim);
  void release(Time now);
  std::optional<Lane> choose() const;

  std::size_t limit_;
  std::size_t longest_ = std::numeric_limits<std::size_t>::max();
  std::size_t bytes_ = 0;
  std::uint64_t numbers_ = 0, ordered_accepted_ = 0, ordered_pending_ = 0;
  // Oldest first: messages of one frame; longer ones, and what must not overtake them.
  std::array<Entries, lanes> waiting_;
  std::size_t ahead_ = 0;                       // bytes that the first lane had since the second
  bool cut_ = false;                            // the first message of the second is handed out in part
  std::size_t held_ = 0;                        // messages of all channels that are held back
  Entries leaving_;                             // handed out as a whole, in that order
  Entries in_flight_;                           // and written
  std::uint64_t handed_out_ = 0, written_ = 0;  // bytes, since the beginning
  std::map<std::string, Channel, std::less<>> channels_;
};

}  // namespace arkmesh::gateway
