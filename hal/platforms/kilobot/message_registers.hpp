// The overhead controller's airtime: one infrared message at a time for the whole arena, each with room for words to
// three robots, or for one whole message. Registers per receiver and slot hold what is newest; fleet commands go first.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/counters.hpp"
#include "hal/platforms/kilobot/fleet_queue.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "hal/platforms/kilobot/message.hpp"
#include "hal/robot/set_point.hpp"

namespace arkmesh::hal::kilobot {

class MessageRegisters final : public hal::RobotLink {
 public:
  // Both outlive the board.
  MessageRegisters(const hal::ArenaInfo& info, hal::Counters& counters)
      : info_(info), layout_(layout_of(info)), counters_(counters) {}

  void offer(std::span<const hal::ToRobot> newest) override;
  hal::Airtime airtime() const override { return airtime_; }
  void command(const hal::FleetCommand& command) override;
  hal::NotHeard not_heard() override { return std::exchange(not_heard_, {}); }
  std::vector<hal::FromRobot> heard() override { return std::exchange(heard_, {}); }
  // What a robot said, which only simulated ones do. At most 65536 words wait; more are dropped and counted.
  void hear(const hal::FromRobot& said) {
    if (heard_.size() == most_heard) return counters_.add("from_robots.dropped");
    heard_.push_back(said);
  }

  using SetPoints = std::vector<std::pair<hal::RobotId, hal::SetPoint>>;
  struct Outgoing {
    Message message;
    bool has_words = false;                 // to single robots, in groups
    std::optional<hal::RobotId> only_to{};  // whom it is for, of a whole message to one robot
    bool is_command = false;                // to the fleet
    // Of simulated robots that have wheels: what goes out beside the message, each in a word's time.
    SetPoints set_points{};
  };
  // What goes on the air now; nothing when nothing waits. Receivers take turns: who is passed over, because a whole
  // message does not fit beside words, is the next.
  std::optional<Outgoing> next();
  bool has_waiting() const { return !commands_.empty() || !waiting_.empty(); }
  // For controllers that know better when commands go out: next() does not see what they take.
  FleetQueue& commands() { return commands_; }
  // A command that the platform carries, without asking.
  void put(const hal::FleetCommand& command);

  // For controllers that know better than to send: take back what waits for one robot or for all, and account for a
  // message that is not even stored. All give the number of messages, which Airtime then holds as not_sent; the caller
  // counts why. not_heard() tells of them, as of what else the controller gives up.
  std::uint64_t drop(hal::RobotId robot);
  std::uint64_t drop_all();
  void decline(hal::RobotId robot);
  hal::NotHeard& given_up() { return not_heard_; }

 private:
  std::uint64_t give_up(std::uint64_t messages);

  struct Register {
    std::uint8_t kind;
    std::uint32_t value;
    std::optional<hal::WholeMessage> whole;
    std::optional<hal::SetPoint> wheels{};
  };
  struct Waiting {
    std::map<std::uint8_t, Register> by_slot;
    std::uint8_t next_slot = 0;  // where this receiver's round goes on
    std::map<std::uint8_t, Register>::iterator next() {
      const auto at = by_slot.lower_bound(next_slot);
      return at == by_slot.end() ? by_slot.begin() : at;
    }
  };
  Register take(hal::RobotId receiver, Waiting& waiting);

  const hal::ArenaInfo& info_;
  const WordLayout layout_;
  hal::Counters& counters_;
  FleetQueue commands_;
  std::map<hal::RobotId, Waiting> waiting_;  // receivers with something waiting; `everyone` is the last of a round
  hal::RobotId next_receiver_ = 0;           // where the round over receivers goes on
  hal::Airtime airtime_;
  static constexpr std::size_t most_heard = 1 << 16;
  std::vector<hal::FromRobot> heard_;
  hal::NotHeard not_heard_;
};

}  // namespace arkmesh::hal::kilobot
