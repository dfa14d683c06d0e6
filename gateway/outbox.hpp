// What waits to be sent to one peer, bounded in bytes. Decides what is replaced and what is dropped when the peer is
// slow or away; never talks to anybody itself. What has been handed out for writing stays here, and counts, until it is
// written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <list>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/link.hpp"
#include "hal/counters.hpp"

namespace arkmesh::gateway {

class Outbox {
 public:
  // What one waiting message costs beside its own bytes: list node, map entry, allocator. Counted against the limit.
  static constexpr std::size_t overhead_bytes = 160;

  explicit Outbox(std::size_t limit_bytes) : limit_(limit_bytes) {}
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  // Takes a message as it goes on the byte stream. `latest`: replaces a waiting one of the same channel, in its place
  // in the queue. When there is no room the oldest `ordered` ones go first, then the oldest `latest` ones; all counted.
  // False when it was refused: too long, or all room is taken by what is being written.
  bool put(Delivery delivery, std::string_view channel, std::vector<std::byte> message);

  // Longer messages are refused from now on; those that wait are dropped. All counted.
  void set_longest(std::size_t message_bytes);

  // The next messages to write, oldest first: at most `max_messages`, and at most `max_bytes` unless the first alone
  // is larger. Begins where written() left off. Valid until the next call of written() or rewind(); put() does not
  // touch them.
  std::vector<std::span<const std::byte>> batch(std::size_t max_messages, std::size_t max_bytes);
  // So many bytes of the batch have been written. Returns what is complete by that.
  struct Written {
    std::size_t messages = 0;
    std::size_t bytes = 0;  // of these messages, without their channel names
  };
  Written written(std::size_t bytes);
  // The first message is partly written.
  bool in_message() const { return first_written_ > 0; }
  // The session ended in the middle: the message that was cut is to be written again from its beginning.
  void rewind();

  bool empty() const { return entries_.empty(); }
  std::size_t messages() const { return entries_.size(); }
  // Including overhead; never above the limit.
  std::size_t bytes() const { return bytes_; }
  std::size_t limit_bytes() const { return limit_; }
  // outbox.replaced.<channel>, outbox.dropped.full.<channel>, outbox.refused.too_big.<channel>.
  hal::Counters counters() const;

 private:
  struct Channel;
  struct Entry {
    Channel* channel;  // node of channels_, which never moves
    Delivery delivery;
    std::vector<std::byte> message;
  };
  using Entries = std::list<Entry>;
  struct Channel {
    std::string name;
    Entries::iterator waiting;  // the `latest` entry that a newer one replaces
    bool has_waiting = false;
    std::uint64_t replaced = 0, dropped = 0, refused = 0;
  };

  static std::size_t cost(const Entry& entry) { return entry.message.capacity() + overhead_bytes; }
  Channel& channel(std::string_view name);
  void erase(Entries::iterator entry);
  bool make_room(std::size_t wanted);
  // Of the first `from` messages, which were handed out, only the first `down_to` still are.
  void take_back(std::size_t from, std::size_t down_to);

  std::size_t limit_;
  std::size_t longest_ = std::numeric_limits<std::size_t>::max();
  std::size_t bytes_ = 0;
  Entries entries_;  // oldest first; the first handed_out_ of them are being written
  std::size_t handed_out_ = 0;
  std::size_t first_written_ = 0;  // bytes of the first entry that are on their way
  std::map<std::string, Channel, std::less<>> channels_;
};

}  // namespace arkmesh::gateway
