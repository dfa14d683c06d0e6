#include "hal/platforms/kilobot/overhead_controller.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace arkmesh::hal::kilobot {
namespace {

using std::chrono::microseconds;

using Kind = FleetCommand::Kind;

constexpr int stops_for_sure = 3;  // where the line may spoil one
// A robot that was out of reach walks for so long at most; the rest of the airtime is others'.
constexpr microseconds pause_again_after{3'000'000}, pause_again_for{200'000};
// Robots that walk although they were told to stand: half of the airtime at first, for a line that spoils packets. A
// line that takes bytes and brings none passes them on later, at its own speed, and robots hear the last of them: so
// after some tries little is said, and until the robots were seen to stand nothing else.
constexpr microseconds urged_again_after{500'000}, urged_later_after{2'000'000}, walks_until_seen{1'500'000};
constexpr int urged_at_length = 2;

// Gives the words that are for robots in the list to nobody. Returns for whom they were.
std::vector<RobotId> blank(MessageRegisters::Outgoing& outgoing, const WordLayout& layout,
                           std::span<const RobotId> robots) {
  std::vector<RobotId> blanked;
  if (!outgoing.has_words) return blanked;
  Message& composite = outgoing.message;
  for (std::size_t group = 0; group < groups; ++group) {
    const RobotId robot = word_in(composite, group, layout).robot;
    if (robot == nobody(layout) || !std::ranges::binary_search(robots, robot)) continue;
    put_word(composite, group, layout, {.robot = nobody(layout)});
    blanked.push_back(robot);
  }
  composite.crc = message_crc(composite);
  return blanked;
}

}  // namespace

void OverheadSettings::fields(const Section& kilobot) {
  kilobot.field("once", once,
                {.help = "send each composite once (packet type 6), instead of repeating it for the spacing"});
  kilobot.field("spacing_s", spacing,
                {{0.04, 10}, "s", "time from the start of a packet to the next; at least 0.05, unless once = true"});
  kilobot.field("command_s", command_for, {{0.05, 60}, "s", "duration for which a command to all robots is repeated"});
  kilobot.field("broadcast_s", broadcast_for, {{0.05, 60}, "s", "duration for which a broadcast is repeated"});
  kilobot.field("waking_s", waking_for,
                {{0.05, 60}, "s", "duration for which the first command after `sleep` is repeated"});
  kilobot.field("expire_s", expire_after,
                {{0, 3600}, "s", "messages that wait this long for a lost connection are dropped"});
  kilobot.field("again_s", again_after, {{0, 10}, "s", "standing messages are sent again after this time; 0: never"});
  kilobot.field("settle_s", settle, {{0, 60}, "s", "delay after opening the port, for controllers that restart then"});
}

void OverheadSettings::check(const Section& kilobot) const {
  if (!once && spacing < microseconds{50'000})
    kilobot.refuse("spacing_s",
                   "must be at least 0.05: the next packet distorts what the controller repeats; 0.04 is possible with "
                   "once = true");
  if (again_after > microseconds{0} && again_after < usual_spacing)
    kilobot.refuse("again_s", "must be 0 or at least 0.055, the airtime of a copy");
}

LabTime message_period(const Section& arena) {
  return arena.section("kilobot").read<OverheadSettings>().spacing;
}

void OverheadController::offer(std::span<const ToRobot> newest) {
  if (withheld_.empty()) return registers_.offer(newest);
  for (const ToRobot& message : newest) {
    if (std::ranges::binary_search(withheld_, message.robot)) {
      registers_.decline(message.robot);
      counters_.add("to_robots.withheld.doubtful");
    } else {
      registers_.offer({&message, 1});
    }
  }
}

void OverheadController::command(const FleetCommand& command) {
  if (const char* reason = command_refusal(info_, command)) return counters_.add(reason);
  if (is_word(command) && command.kind == wanted_) {
    // whoever says it once more wants it heard by robots that did not, such as one that was switched on since
    if (!is_on_its_way(command.kind)) commands_.put(command);
    return;
  }
  registers_.put(command);
  if (command.kind == Kind::broadcast) return;
  ran_ = wanted_ == Kind::run;
  wanted_ = command.kind == Kind::reset ? Kind::pause : command.kind;
  said_since_.reset();
  urged_ = reset_ = false;
  sender_.expect_start();
  urges_ = 0;
  walking_until_ = {};
  cut_ = makes_stand(command);
}

// `run` is not while robots have to hear something before it.
bool OverheadController::is_on_its_way(Kind word) const {
  if (word == Kind::run && !commands_.empty()) return commands_.back().kind == word;
  return commands_.has_word() || (on_air_command_ && on_air_command_->command.kind == word);
}

NotHeard OverheadController::not_heard() {
  NotHeard out = registers_.not_heard();
  out.openings = sender_.openings();
  return out;
}

void OverheadController::urge(TimePoint now) {
  if (wanted_ != Kind::pause || !said_since_) return;
  walking_until_ = now + walks_until_seen;
  urged_ = urges_ < urged_at_length;
  again_at_ = std::min(again_at_, now + (urged_ ? urged_again_after : urged_later_after));
}

void OverheadController::doubt_line() {
  if (reset_ || wanted_ != Kind::pause || !said_since_ || said_over_ != openings_ || !sender_.reset()) return;
  reset_ = true;
  counters_.add("overhead.connection_reset");
}

void OverheadController::withhold(std::span<const RobotId> robots, TimePoint now) {
  withheld_.assign(robots.begin(), robots.end());
  for (const RobotId robot : withheld_) counters_.add("to_robots.withheld.doubtful", registers_.drop(robot));
  if (composite_)
    for (const RobotId robot : blank(*composite_, layout_of(info_), withheld_)) {
      counters_.add("to_robots.withheld.doubtful");
      registers_.given_up().words.insert(robot);
    }
  if (auto heard = on_air_composite_; heard && !blank(*heard, layout_of(info_), withheld_).empty())
    sender_.cut_short(now);
}

void OverheadController::poll(TimePoint now) {
  sender_.poll(now);
  note_loss();
  if (!held_) {
    commands_.note_time(now);
    expire(now);
  }
  if (std::exchange(cut_, false)) cut_short(now);
  if (!sender_.is_ready(now)) return;
  if (repeat_command(now)) return;
  end_command(now);
  repeat_word(now);
  if (send_command(now)) return;
  // the question and the composites take turns; a question that stands alone is repeated by the controller itself
  const bool wants_composite = !held_ && now >= walking_until_ && (composite_ || registers_.has_waiting());
  if (question_ && (asked_ != question_ || !wants_composite) && send_question(now)) return;
  if (wants_composite && send_composite(now)) return;
  // a line that held bytes back may bring the stop right behind the pause
  if (!question_ && !(reset_ && now < walking_until_)) send_stop(now);
}

// A stop that the line spoils would leave the last words on the air for ever.
void OverheadController::send_stop(TimePoint now) {
  if (sender_.is_repeating())
    stops_left_ = says_again() ? stops_for_sure : 1;
  else if (stops_left_ == 0 || now - stopped_at_ < settings_.again_after)
    return;
  sender_.separate(now);
  asked_.reset();
  on_air_composite_.reset();
  stopped_at_ = now;
  --stops_left_;
}

// A line that was lost took with it what the controller was repeating; and nobody knows what robots heard.
void OverheadController::note_loss() {
  const bool lost = !sender_.is_up() || sender_.openings() != openings_;
  openings_ = sender_.openings();
  if (!lost) return;
  asked_.reset();
  stops_left_ = 0;
  on_air_composite_.reset();
  if (on_air_command_ && !is_word(on_air_command_->command)) {
    commands_.put_first(on_air_command_->command);
    counters_.add("fleet_command.repeated_after_loss");
  }
  on_air_command_.reset();
  if (wanted_ && !commands_.has_word()) commands_.put_first({.kind = *wanted_});
  if (std::exchange(pause_first_, false) && wanted_ == Kind::run) commands_.put_first({.kind = Kind::pause});
}

void OverheadController::expire(TimePoint now) {
  if (sender_.is_up()) return down_since_.reset();
  if (!down_since_) down_since_ = now;
  if (now - *down_since_ <= settings_.expire_after) return;
  const std::vector<std::uint8_t> expired = commands_.expire(now - settings_.expire_after);
  counters_.add("fleet_command.expired", expired.size());
  registers_.given_up().broadcasts.insert(expired.begin(), expired.end());
  drop_waiting();
}

// What waits for single robots.
void OverheadController::drop_waiting() {
  counters_.add("to_robots.expired", registers_.drop_all());
  if (!composite_) return;
  counters_.add("overhead.dropped.composite");
  const std::vector<RobotId> robots = blank(*composite_, layout_of(info_), info_.robots);
  registers_.given_up().words.insert(robots.begin(), robots.end());
  composite_.reset();
}

// For a word after which robots stand; one that is on the air already is not cut by the next.
void OverheadController::cut_short(TimePoint now) {
  if (!on_air_command_ || makes_stand(on_air_command_->command)) return;
  sender_.cut_short(now);
  counters_.add("fleet_command.cut_short");
  on_air_command_.reset();
}

microseconds OverheadController::length_of(const FleetCommand& command) const {
  if (command.kind == Kind::broadcast) return settings_.broadcast_for;
  if (asleep_ && command.kind != Kind::sleep) return std::max(settings_.command_for, settings_.waking_for);
  return repeated_ && !urged_ ? std::min(settings_.command_for, pause_again_for) : settings_.command_for;
}

// The word that stands, when it is time to say it again.
void OverheadController::repeat_word(TimePoint now) {
  if (wanted_ != Kind::pause || !said_since_ || now < again_at_ || commands_.has_word()) return;
  commands_.put_first({.kind = Kind::pause});
  if (now < walking_until_) ++urges_;
  repeated_ = true;
  counters_.add("fleet_command.said_again");
}

bool OverheadController::send_command(TimePoint now) {
  if (commands_.empty() || (held_ && !makes_stand(commands_.front()))) return false;
  if (reset_ && repeated_ && sender_.is_repeating()) return sender_.separate(now), true;
  const FleetCommand command = commands_.front();
  const microseconds all = length_of(command), first = says_again() ? std::min(all, settings_.again_after) : all;
  // true even if a stop had to go first: nothing may overtake
  if (!sender_.send(forward_packet(fleet_message(command)), first, now)) return true;
  counters_.add("fleet_command.sent");
  asleep_ = asleep_ || command.kind == Kind::sleep;
  on_air_command_ = {command, all - first};
  commands_.take();
  asked_.reset();
  on_air_composite_.reset();
  return true;
}

// It has been on the air for as long as it should.
void OverheadController::end_command(TimePoint now) {
  if (!on_air_command_) return;
  const Kind kind = on_air_command_->command.kind;
  on_air_command_.reset();
  if (kind == Kind::broadcast) return;
  repeated_ = urged_ = false;
  again_at_ = now + (kind == Kind::reset ? microseconds{0} : pause_again_after);
  asleep_ = asleep_ && kind == Kind::sleep;
  if (said_since_ || commands_.has_word()) return;
  said_since_ = now;
  said_over_ = openings_;
  if (wanted_ == Kind::pause && ran_) walking_until_ = now + walks_until_seen;  // nobody has looked yet
}

// By turns a stop and the command, until it has been on the air for as long as it should.
bool OverheadController::repeat_command(TimePoint now) {
  if (!on_air_command_) return false;
  microseconds& left = on_air_command_->left;
  if (left < stop_spacing + usual_spacing && sender_.is_repeating()) return false;
  if (sender_.is_repeating()) {
    sender_.separate(now);
    left -= stop_spacing;
  } else {
    const microseconds next = std::min(left, settings_.again_after);
    left -= next;
    std::ignore = sender_.send(forward_packet(fleet_message(on_air_command_->command)), next,
                               now);  // behind a stop nothing is in its way
  }
  return true;
}

bool OverheadController::send_question(TimePoint now) {
  if (asked_ == question_) {
    if (!says_again() || now - asked_at_ < settings_.again_after) return true;  // the controller repeats it
    sender_.separate(now);
    asked_.reset();
    return true;
  }
  // a question is repeated by the controller, whatever composites are
  if (!sender_.send(forward_packet(*question_), std::max(settings_.spacing, usual_spacing), now)) return true;
  counters_.add("overhead.questions");
  asked_ = question_;
  asked_at_ = now;
  on_air_composite_.reset();
  return true;
}

bool OverheadController::send_composite(TimePoint now) {
  if (!composite_) composite_ = registers_.next();
  if (!composite_) return false;
  const Message& message = composite_->message;
  const Packet packet = settings_.once ? forward_once_packet(message) : forward_packet(message);
  // a message that interrupts a repetition waits for its end, up to 10.4 ms
  const microseconds hold = sender_.is_repeating() ? std::max(settings_.spacing, usual_spacing) : settings_.spacing;
  if (!sender_.send(packet, hold, now)) return true;
  on_air_composite_ = std::exchange(composite_, std::nullopt);
  asked_.reset();
  return true;
}

void OverheadController::finish() {
  held_ = false;
  drop_waiting();
  question_.reset();
}

void OverheadController::stop_sending(TimePoint now) {
  finish();
  counters_.add("fleet_command.expired", commands_.drop_all());
  on_air_command_.reset();
  walking_until_ = {};
  wanted_.reset();
  sender_.cut_short(now);
}

bool OverheadController::is_silent(TimePoint now) const {
  return !sender_.is_up() || (!registers_.has_waiting() && !composite_ && !question_ && !sender_.is_repeating() &&
                              stops_left_ == 0 && sender_.is_ready(now));
}

}  // namespace arkmesh::hal::kilobot
