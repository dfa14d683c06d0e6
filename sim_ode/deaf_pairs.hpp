// Robots that were in reach of a sender for long and heard nothing of it. Counts pairs, each direction by itself; knows
// neither places nor light: who carries the messages tells it who is in reach and who heard.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace arkmesh::sim_ode {

class DeafPairs {
 public:
  explicit DeafPairs(int robots)
      : states_(static_cast<std::size_t>(robots), looks_each - 1), senders_(states_.size()) {}

  // A message goes out. True for one of 16: then reaches() is due for each robot in its reach.
  bool sends(int sender, std::int64_t at_us) {
    std::uint8_t& state = states_[static_cast<std::size_t>(sender)];
    state = static_cast<std::uint8_t>((state & waits) | ((state + 1) % looks_each));
    if (state % looks_each != 0) return false;
    look(static_cast<std::size_t>(sender), at_us);
    return true;
  }
  void reaches(int listener);
  // Somebody in the sender's reach has heard nothing of it yet: then hears() is due for who hears.
  bool has_unheard(int sender) const { return (states_[static_cast<std::size_t>(sender)] & waits) != 0; }
  void hears(int sender, int listener);

  // Of pairs that were in reach for 60 s and longer: all, and those of whose messages none came.
  struct Totals {
    std::uint64_t in_reach = 0, deaf = 0;
  };
  Totals totals() const;

 private:
  static constexpr std::uint8_t looks_each = 16, waits = 128;
  struct Pair {
    int listener;
    bool heard;
    std::int64_t since_us, until_us;
  };
  struct Sender {
    std::int64_t looked_us = 0;
    int unheard = 0;  // of its pairs
    std::vector<Pair> pairs;
  };
  static void add(const Pair& pair, Totals& totals);
  void look(std::size_t sender, std::int64_t at_us);

  // By robot: messages since it was looked at, and `waits` when it has pairs that are unheard. Nothing else is looked
  // at with most messages.
  std::vector<std::uint8_t> states_;
  std::vector<Sender> senders_;
  std::size_t sender_ = 0, next_ = 0;  // next_: among its pairs, the listener that is probably named next
  Totals parted_;                      // of pairs that are in reach no more
};

}  // namespace arkmesh::sim_ode
