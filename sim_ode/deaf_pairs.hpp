// Robots that were in reach of a sender for long and heard nothing of it. Counts pairs, each direction by itself; knows
// neither places nor light: who carries the messages tells it who is in reach and who heard.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace arkmesh::sim_ode {

class DeafPairs {
 public:
  explicit DeafPairs(int robots);

  // A message goes out. True for one of 16: then reaches() is due for each robot in its reach.
  bool sends(int sender, std::int64_t at_us) {
    sender_ = static_cast<std::size_t>(sender);
    if (senders_[sender_].messages++ % 16 != 0) return false;
    look(at_us);
    return true;
  }
  void reaches(int listener);
  void hears(int sender, int listener) {
    const std::size_t bit = bit_of(static_cast<std::size_t>(sender), listener);
    heard_[bit / 64] |= std::uint64_t{1} << bit % 64;
  }

  // Of pairs that were in reach for 60 s and longer: all, and those of whose messages none came.
  struct Totals {
    std::uint64_t in_reach = 0, deaf = 0;
  };
  Totals totals() const;

 private:
  struct Pair {
    int listener;
    bool heard;
    std::int64_t since_us, until_us;
  };
  struct Sender {
    std::uint32_t messages = 0;
    std::int64_t looked_us = 0;
    std::vector<Pair> pairs;
  };
  // Very many robots share bits, so that a deaf one may seem to hear.
  std::size_t bit_of(std::size_t sender, int listener) const {
    return sender * width_ + (static_cast<std::size_t>(listener) & (width_ - 1));
  }
  static void add(const Pair& pair, Totals& totals);
  void look(std::int64_t at_us);

  std::size_t width_;                 // bits of a sender in heard_, a power of two
  std::vector<std::uint64_t> heard_;  // since the sender was last looked at
  std::vector<Sender> senders_;
  std::size_t sender_ = 0, next_ = 0;  // next_: among its pairs, the listener that is probably named next
  Totals parted_;                      // of pairs that are in reach no more
};

}  // namespace arkmesh::sim_ode
