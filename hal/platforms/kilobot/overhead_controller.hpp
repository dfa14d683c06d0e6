// The way to a testbed of Kilobots: decides what the overhead controller says next. Fleet commands first, then the
// standing question and the registers of single robots in turn, and silence when there is nothing to say, because
// robots talk to each other on the same channel. What matters goes over the line more than once, because nobody says
// whether it came through. What robots should do is said anew after each opening of the line, and `pause` every few
// seconds for as long as it is wanted: robots may have been out of reach. Time is the caller's; nothing here blocks.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/config/config.hpp"
#include "hal/counters.hpp"
#include "hal/platforms/kilobot/message_registers.hpp"
#include "hal/platforms/kilobot/packet_port.hpp"
#include "hal/platforms/kilobot/packet_sender.hpp"

namespace arkmesh::hal::kilobot {

// Keys of [arena.kilobot].
struct OverheadSettings {
  std::chrono::microseconds spacing = usual_spacing;  // start to start of packets; at least 0.05, with `once` 0.04
  bool once = false;  // composites are sent once (packet type 6), not repeated for the spacing
  std::chrono::microseconds command_for{500'000};    // a fleet command is repeated for so long
  std::chrono::microseconds broadcast_for{200'000};  // a broadcast
  std::chrono::microseconds waking_for{10'000'000};  // the command after `sleep`; robots asleep listen every 8 s
  std::chrono::microseconds expire_after{
      5'000'000};                            // what could not be sent for so long, the line being down, is dropped
  std::chrono::microseconds again_after{0};  // what stays on the air goes over the line again, behind a stop; 0: never
  std::chrono::microseconds settle{2'500'000};  // a controller that starts when its port opens is deaf for so long

  void fields(const Section& kilobot);
  void check(const Section& kilobot) const;
};

// From the start of one message with words to the next, as [arena.kilobot] says. Throws ConfigError.
LabTime message_period(const Section& arena);

// Counts `fleet_command.sent`, `.said_again` (a word that stands), `.replaced`, `.cut_short`, `.repeated_after_loss`,
// `.expired`, `.refused.type`, `.refused.too_many`, `to_robots.expired`, `to_robots.withheld.doubtful`,
// `overhead.questions`, `.connection_reset`, `.dropped.composite`, and what its parts count.
class OverheadController final : public RobotLink {
 public:
  // All outlive this.
  OverheadController(const ArenaInfo& info, PacketPort& line, const OverheadSettings& settings, Counters& counters)
      : info_(info),
        settings_(settings),
        counters_(counters),
        registers_(info, counters),
        sender_(line, settings.settle, counters) {}

  void offer(std::span<const ToRobot> newest) override;
  Airtime airtime() const override { return registers_.airtime(); }
  void command(const FleetCommand& command) override;
  NotHeard not_heard() override;
  std::vector<FromRobot> heard() override { return {}; }

  // What all robots should hear over and over; nothing ends it. While it stands it takes every second packet if single
  // robots have messages waiting, and all the airtime if not.
  void ask(std::optional<Message> question) { question_ = question; }
  // Robots, ascending, to whom nothing may be said: what waits for them is dropped, what is on the air ends, new offers
  // are dropped.
  void withhold(std::span<const RobotId> robots, TimePoint now);
  // A robot that may have begun anew since.
  void note_restart(RobotId robot) { registers_.given_up().restarted.insert(robot); }
  // While on hold only questions go out, and what makes robots stand; the rest waits, without ageing. For the time
  // before an experiment begins.
  void hold(bool on) { held_ = on; }
  // What the robots should do; nothing before the first word.
  std::optional<FleetCommand::Kind> wanted() const { return wanted_; }
  // Since when what is wanted has been said, for as long as it is to be repeated; nothing: not yet.
  std::optional<TimePoint> said_since() const { return said_since_; }
  // Somebody was seen not to do what is wanted: `pause` is said again soon, at first at length, and messages for single
  // robots wait until nobody was urged for 1.5 s, likewise behind the word that ends a run.
  void urge(TimePoint now);
  // Nobody seems to have heard `pause`: a connection is reset, once for each word, and says it anew. What was written
  // before would come first.
  void doubt_line();
  // Somebody else told the robots to stand, and the line is about to be lost: when it is back they are told so again,
  // and then what is wanted.
  void pause_first() { pause_first_ = true; }
  // Sends what is due. Call it at the times that due() gives, or more often.
  void poll(TimePoint now);
  TimePoint due(TimePoint now) const { return sender_.due(now); }
  bool is_up() const { return sender_.is_up(); }
  // Towards the end: forgets the question and what waits for single robots. Fleet commands still go out.
  void finish();
  // At the end: forgets the commands as well and ends the one that is on the air; poll() then only stops the
  // controller.
  void stop_sending(TimePoint now);
  // Nothing is on the air and nothing waits.
  bool is_silent(TimePoint now) const;

 private:
  struct OnAir {
    FleetCommand command;
    std::chrono::microseconds left{0};  // of the time for which it is repeated
  };
  void expire(TimePoint now);
  void drop_waiting();
  void note_loss();
  bool is_on_its_way(FleetCommand::Kind word) const;
  void cut_short(TimePoint now);
  bool send_command(TimePoint now);
  bool repeat_command(TimePoint now);
  void end_command(TimePoint now);
  void repeat_word(TimePoint now);
  std::chrono::microseconds length_of(const FleetCommand& command) const;
  void send_stop(TimePoint now);
  bool says_again() const { return settings_.again_after.count() > 0; }
  bool send_question(TimePoint now);
  bool send_composite(TimePoint now);

  const ArenaInfo& info_;
  OverheadSettings settings_;
  Counters& counters_;
  MessageRegisters registers_;
  PacketSender sender_;
  FleetQueue& commands_ = registers_.commands();
  std::optional<OnAir> on_air_command_;
  std::optional<FleetCommand::Kind> wanted_;
  std::optional<TimePoint> said_since_;
  TimePoint again_at_{}, walking_until_{};  // when a `pause` that stands is said again; until when others wait for it
  bool ran_ = false;                        // robots were to run before the word that is wanted
  int urges_ = 0;                           // how often it was said to robots that walked
  bool reset_ = false;                      // the connection, for the word that is wanted
  std::uint64_t said_over_ = 0;             // the opening of the line over which it was said
  bool urged_ = false, repeated_ = false;   // at length; the word that is on the air was said before
  bool asleep_ = false;                     // robots may be, since they were told to and until they were woken
  bool pause_first_ = false;
  bool cut_ = false;  // what is on the air must make way for a word
  std::optional<Message> question_;
  std::optional<Message> asked_;  // the question that was sent last, while the last packet was one
  TimePoint asked_at_{}, stopped_at_{};
  int stops_left_ = 0;                                   // to be sent while there is nothing to say
  std::optional<MessageRegisters::Outgoing> composite_;  // made up, to be sent
  std::optional<MessageRegisters::Outgoing> on_air_composite_;
  std::vector<RobotId> withheld_;
  bool held_ = false;
  std::optional<TimePoint> down_since_;
  std::uint64_t openings_ = 0;
};

}  // namespace arkmesh::hal::kilobot
