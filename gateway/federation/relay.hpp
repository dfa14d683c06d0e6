// One lab's end of the streams between it and a peer: makes two streams of bytes, whole and in order, of pieces that
// may be lost, repeated, late and out of order. Sends again from where the peer has it all, and knows when a peer's end
// is another than before. Pure; the caller owns time and packets.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "gateway/federation/packet.hpp"
#include "hal/counters.hpp"

namespace arkmesh::gateway {

// Bytes that travel as a whole, perhaps to several peers.
struct Chunk {
  std::vector<std::byte> bytes;
  bool is_message = false;  // of a channel; else about the session itself
};
using ChunkPointer = std::shared_ptr<const Chunk>;  // shared by the relays of all peers that get it

class Relay {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::milliseconds;
  // A message that came is acknowledged after so long at the latest, unless acknowledge_within() says otherwise; what
  // is about the session itself with whatever goes next, heartbeats at the latest, for else each acknowledgement would
  // ask for another.
  static constexpr Duration least_ack_time{20};
  // What was sent and not acknowledged is sent again after so long: before the path is known, and within these.
  static constexpr Duration first_patience{300}, least_patience{80}, longest_patience{1000};
  // What has come and nobody has read; more is not taken, and not acknowledged.
  static constexpr std::size_t max_unread_bytes = 1 << 20;

  explicit Relay(StreamId mine) : mine_(mine) {}

  StreamId mine() const { return mine_; }
  StreamId yours() const { return yours_; }
  // The peer has named our end, so it is there now.
  bool met() const { return met_; }
  // The peer's end is gone, or is another one.
  bool ended() const { return ended_; }

  // Whether it is to be answered, with greeting(greeting.mine). `at`: the packet that it is in.
  bool hear(const Greeting& greeting, PacketOrder at);
  Greeting greeting(std::string to, StreamId yours) const { return {std::move(to), mine_, yours, !met_}; }
  // A piece for our end. False when it acknowledges what was never sent: that is the end of the stream.
  bool take(const Piece& piece, const PacketBody& body, PacketOrder at, Time now);
  void hear(const Ending& ending) { ended_ |= ending.mine == yours_; }
  // What has come and was not read yet.
  std::vector<std::byte>& unread() { return unread_; }

  void put(ChunkPointer chunk);
  // What goes next; null when all was sent.
  const Chunk* next() const { return next_ < chunks_.size() ? chunks_[next_].chunk.get() : nullptr; }
  ChunkPointer share_next() const { return chunks_[next_].chunk; }
  // It was sent before.
  bool sends_again() const { return next_ < once_sent_; }
  // A message waits that was not sent before.
  bool has_fresh_message() const;
  // Without chunks, as from what goes next.
  Piece piece();
  // next() is in a packet now. Whether it is to be acknowledged soon.
  bool sent(Time now);
  // Sends again what the peer had time to acknowledge.
  void check(Time now);
  // All that is not acknowledged is to be sent again: the path was gone.
  void send_all_again();
  void acknowledge_within(Duration time) { ack_time_ = time; }
  // An acknowledgement is due that nothing else has carried.
  bool owes_answer(Time now) const { return asks_again_ || (owes_since_ && now - *owes_since_ >= ack_time_); }

  // pieces.repeated, pieces.missing, pieces.sent_again, pieces.full
  const hal::Counters& counters() const { return counters_; }

 private:
  struct Entry {
    ChunkPointer chunk;
    std::uint64_t end;  // offset behind it
    bool is_urgent;     // a message, or at the beginning of the stream
  };
  struct Sample {
    std::uint64_t end;
    Time sent;
  };
  bool awaits_urgently() const;
  bool has_exchanged() const { return came_ > 0 || acknowledged_ > 0; }
  bool is_of_the_past(StreamId theirs, PacketOrder at) const { return met_ && theirs != yours_ && at < met_at_; }
  void meet(StreamId theirs, PacketOrder at);
  bool acknowledged(std::uint64_t total, Time now);
  void rewind(Time now);

  StreamId mine_, yours_ = 0;
  bool met_ = false, ended_ = false;
  PacketOrder met_at_{};  // in which packet the peer's present end was met
  // Ours.
  std::deque<Entry> chunks_;  // not acknowledged
  std::size_t next_ = 0, once_sent_ = 0;
  std::uint64_t put_ = 0, acknowledged_ = 0;
  std::uint64_t highest_sent_ = 0;
  Time progress_{}, rewound_{};
  std::optional<Sample> sample_;
  std::optional<std::chrono::duration<double>> path_;  // there and back, smoothed
  Duration patience_ = first_patience;
  // The peer's.
  std::uint64_t came_ = 0;
  std::vector<std::byte> unread_;
  Duration ack_time_ = least_ack_time;
  std::optional<Time> owes_since_;
  bool asks_again_ = false;
  hal::Counters counters_;
};

}  // namespace arkmesh::gateway
