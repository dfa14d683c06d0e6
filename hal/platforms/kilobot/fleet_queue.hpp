// What waits to be said to all robots at once: at most one word about what they should do, which the next one replaces,
// at most one reset, and broadcasts in order.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/platforms/kilobot/message.hpp"
#include "hal/time/wall_time.hpp"

namespace arkmesh::hal::kilobot {

// The infrared message of a fleet command, its checksum included. For a broadcast, `type` must be at most 127.
Message fleet_message(const hal::FleetCommand& command);
// Why a command cannot be sent, as its counter's name; null when it can.
const char* command_refusal(const hal::ArenaInfo& info, const hal::FleetCommand& command);
// Whether the command says what robots should do from now on, as all but reset and broadcast do.
bool is_word(const hal::FleetCommand& command);

// Whether robots that have heard it stand: all words but `run`, and a reset.
bool makes_stand(const hal::FleetCommand& command);

class FleetQueue {
 public:
  static constexpr std::size_t max_broadcasts = 64;  // a flood is refused, not stored

  // What makes robots stand goes ahead of what waits; `run` goes behind it, so that robots hear the rules first.
  // Returns the counter of what that cost: a word that is replaced, a broadcast too many; null: nothing.
  const char* put(const hal::FleetCommand& command);
  // To be said before everything else.
  void put_first(const hal::FleetCommand& command) { waiting_.push_front({command, {}}); }
  bool empty() const { return waiting_.empty(); }
  bool has_word() const;
  // Call these two only when there is something.
  const hal::FleetCommand& front() const { return waiting_.front().command; }
  const hal::FleetCommand& back() const { return waiting_.back().command; }
  hal::FleetCommand take();
  // What was put since the last call waits from `now` on.
  void note_time(hal::TimePoint now);
  // Drops broadcasts that wait since that moment or an earlier one; gives their types. Words and a reset never expire,
  // nor does what robots are to hear before a `run` that waits.
  std::vector<std::uint8_t> expire(hal::TimePoint since);
  std::size_t drop_all();

 private:
  struct Waiting {
    hal::FleetCommand command;
    std::optional<hal::TimePoint> since;
  };
  std::deque<Waiting> waiting_;
};

}  // namespace arkmesh::hal::kilobot
