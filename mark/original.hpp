// The original as this side knows it: what it says, in the order of its time, and what it is sent, never more than it
// can take. Its messages are its clock (ARGoS), or the wall is (ARK-Qt). Single-threaded; never waits.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "hal/counters.hpp"
#include "hal/time/wall_time.hpp"
#include "hal/types.hpp"
#include "mark/conversation.hpp"
#include "mark/link.hpp"
#include "mark/settings.hpp"
#include "mark/splitter.hpp"

namespace arkmesh::mark {

class Original final : private Link::Events {
 public:
  // What lab time does while the original is away.
  enum class Away : std::uint8_t { stands_still, goes_on };

  // Starts the link, and does not open it. `conversation`, `counters` and `wall` outlive it.
  Original(const Settings& settings, Role role, const Grammar& grammar, Conversation& conversation,
           std::unique_ptr<Link> link, Away away, hal::Counters& counters, hal::WallTime& wall = hal::machine_time());

  // From now on the original may come: its time passes as soon as it does. The first call counts. Throws as Link::open.
  void open();
  // Hears what has come, and says what is due. To be called often, also when the lab has ended.
  void serve();
  hal::TimePoint next_service() const;

  // It is connected, and has said what the lab's state 0 needs.
  bool may_begin() const { return link_->up() && conversation_.may_begin(); }
  // Whether its time is at lab time t > 0: what it said until then has been heard. The first call begins lab time; what
  // it said before has no time. So is, from then on, what it does while it is Settings::ahead before lab time: labs
  // that were paused do not catch up. That is said.
  bool reached(hal::LabTime t);
  // Of ARGoS, on its first connection: how many of its ticks came before lab time began.
  std::uint64_t ticks_before() const { return ticks_before_; }
  // From now on its time does not matter: everything is heard as it comes.
  void end();

  bool up() const { return link_->up(); }
  // Since when it is away, when it was there before. ARK-Qt is so, too, while it is connected and quiet: lab time does
  // not stand still then, and what it said last may be over.
  std::optional<hal::TimePoint> away_since() const;
  // Who and where, and what is wrong: "the original M-ARK client (ARGoS), which has not come to 127.0.0.1:7001". Empty
  // while it is there and says something.
  std::string name() const;
  std::string absence() const;
  // What was refused last, for people; empty when nothing was.
  const std::string& newest_refusal() const { return splitter_.newest_refusal(); }
  // Of the text that came.
  const hal::Counters& refusals() const { return splitter_.counters(); }

 private:
  void came() override;
  void heard(std::string_view bytes) override;
  void gone(const std::string& why) override;
  void hear(const Message& message);
  void hear_ticks(std::size_t ticks, hal::LabTime each);
  void hear_waiting();
  bool quiet() const;
  void skip();
  void say_skipped();
  void say();
  bool may_say(std::size_t size);

  // A message that the original may not have read yet.
  struct Unread {
    std::size_t size = 0;
    std::uint64_t ticks = 0;  // that had come when it was sent
  };

  const Settings settings_;
  const Role role_;
  const Away away_;
  bool open_ = false;
  Conversation& conversation_;
  hal::Counters& counters_;
  hal::WallTime& wall_;
  Splitter splitter_;
  bool begun_ = false, ended_ = false;
  hal::TimePoint zero_{};        // when lab time 0 was, where the wall is its clock: ARK-Qt
  hal::LabTime told_{0};         // lab time that was reached; of ARGoS, by what has been heard
  std::deque<Message> to_hear_;  // of ticks to come
  // What it was further ahead than it may be: in all, as said last, and since lab time `stood_at_`.
  hal::LabTime skipped_{0}, skipped_said_{0}, standing_{0}, stood_at_{0};
  std::uint64_t ticks_ = 0;  // messages that came on this connection
  std::uint64_t ticks_before_ = 0;
  std::uint64_t answered_ = 0;  // of these, when something was sent last
  std::size_t unended_ = 0;     // bytes that came since
  std::deque<Unread> unread_;
  std::string said_;                       // last, on this connection
  hal::TimePoint said_at_{}, heard_at_{};  // the latter: it came, or said something that it may say
  bool quiet_ = false;                     // ARK-Qt, at the last look
  std::optional<hal::TimePoint> away_since_;
  hal::LabTime told_before_{0};  // its time when it went
  std::unique_ptr<Link> link_;   // the last: it dies first
};

}  // namespace arkmesh::mark
