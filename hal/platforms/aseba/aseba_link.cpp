#include "hal/platforms/aseba/aseba_link.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "hal/arenas/robot_words.hpp"
#include "hal/arenas/silent_link.hpp"

namespace arkmesh::hal::aseba {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds beat_each = 500ms, wheels_each = 100ms, wheels_each_later = 500ms,
                                    say_again = 200ms, expire_after = 5s;
constexpr std::size_t most_heard = 10'000;

}  // namespace

void AsebaLink::offer(std::span<const ToRobot> newest) {
  for (const ToRobot& message : newest) {
    ++airtime_.offered;
    if (const char* reason = refusal(info_, message)) {
      ++airtime_.refused;
      counters_.add(reason);
      continue;
    }
    const Register place{message.robot, message.slot};
    const auto [at, fresh] = words_.insert_or_assign(place, Waiting{message, now_});
    if (fresh)
      order_.push_back(place);
    else
      ++airtime_.replaced;
  }
}

Airtime AsebaLink::airtime() const {
  Airtime out = airtime_;
  out.waiting = words_.size();
  return out;
}

void AsebaLink::command(const FleetCommand& command) {
  if (const char* reason = refusal(info_, command)) return counters_.add(reason);
  counters_.add("fleet_command.sent");
  reset_ = reset_ || command.kind == FleetCommand::Kind::reset;
  wanted_ = command.kind == FleetCommand::Kind::run ? command.kind : FleetCommand::Kind::pause;
}

NotHeard AsebaLink::not_heard() {
  return {.openings = nodes_.openings(),
          .broadcasts = {},
          .words = std::exchange(given_up_, {}),
          .restarted = nodes_.take_restarted()};
}

void AsebaLink::poll(TimePoint now) {
  now_ = now;
  nodes_.poll(now);
  watch_programs(now);
  take_events();
  tell_state(now);
  if (released_) send_words(now);
}

void AsebaLink::finish() {
  airtime_.not_sent += words_.size();
  words_.clear();
  order_.clear();
  wanted_ = FleetCommand::Kind::pause;
}

// In turn; who is not there is passed over, and what has waited for it too long is given up.
void AsebaLink::send_words(TimePoint now) {
  next_word_ = std::max(next_word_, now - 50ms);
  for (std::size_t left = order_.size(); left > 0 && next_word_ <= now; --left) {
    const Register place = order_.front();
    order_.pop_front();
    const Waiting& word = words_.at(place);
    const auto speed = set_point_in(info_, word.message);
    if (speed) set_points_[place.first] = *speed;
    const bool sent =
        speed ? should_stand() || nodes_.set_wheels(place.first, *speed)
              : nodes_.tell(place.first, event_word, {word.message.kind, static_cast<int>(word.message.value)});
    if (sent) {
      ++airtime_.sent;
      next_word_ += word_each_;
    } else if (now - word.since < expire_after) {
      order_.push_back(place);
      continue;
    } else {
      ++airtime_.not_sent;
      counters_.add("to_robots.expired");
      given_up_.insert(place.first);
    }
    words_.erase(place);
  }
}

void AsebaLink::take_events() {
  for (const auto& [robot, message] : nodes_.take_events()) {
    const std::vector<int> words = words_of(message);
    if (message.type == event_says && words.size() == 2 && words[0] >= 0 && words[0] < 256) {
      if (heard_.size() < most_heard)
        heard_.push_back({robot, static_cast<std::uint8_t>(words[0]), words[1]});
      else
        counters_.add("from_robots.dropped.too_many");
    } else if (message.type == event_here && words.size() == 2) {
      const auto program = programs_.find(robot);
      if (program == programs_.end()) continue;  // it has not described itself yet
      program->second = {now_, words[0] < 0 ? Led::unknown : led_of(static_cast<unsigned>(words[0]))};
      if (words[1] == 0) continue;
      counters_.add("robots.stopped_alone");
      if (const auto wheels = set_points_.find(robot); wheels != set_points_.end() && !should_stand())
        nodes_.set_wheels(robot, wheels->second);
    } else if (message.type >= event_says) {
      counters_.add("from_robots.ignored.event");
    }
  }
}

// A robot keeps its set points when the lab is gone; only its own program can stop it then.
void AsebaLink::watch_programs(TimePoint now) {
  std::vector<RobotId> unguarded;
  for (const RobotId robot : info_.robots) {
    if (!nodes_.is_here(robot)) {
      programs_.erase(robot);
      continue;
    }
    Program& program = programs_.try_emplace(robot, Program{now}).first->second;
    if (const auto told = told_.find(robot); told != told_.end() && told->second.forced) program.heard_at = now;
    if (program.unguarded || now - program.heard_at <= unguarded_after) continue;
    program = {.heard_at = program.heard_at, .unguarded = true};
    unguarded.push_back(robot);
  }
  if (unguarded.empty()) return;
  counters_.add("robots.unguarded", unguarded.size());
  spdlog::warn("robots {} {}; load robot.aesl into them (hal/platforms/aseba/README.md)", in_words(unguarded),
               runs_no_guard);
}

Led AsebaLink::led(RobotId robot) const {
  const auto program = programs_.find(robot);
  return program == programs_.end() ? Led::unknown : program->second.led;
}

void AsebaLink::tell_state(TimePoint now) {
  const bool stand = should_stand();
  if (std::exchange(reset_, false) && released_) {
    set_points_.clear();
    for (const RobotId robot : info_.robots) {
      nodes_.tell(robot, Type::reset, {});
      nodes_.tell(robot, Type::run, {});
      said_stand_.reset();
    }
  }
  if (said_stand_ != stand || now >= beat_at_) {
    beat_at_ = now + beat_each;
    nodes_.tell_all(event_run, {stand ? stand_still : run_program});
  }
  if (said_stand_ != stand) {
    said_stand_ = stand;
    told_since_ = stand ? std::optional(now) : std::nullopt;
    for (const auto& [robot, told] : std::exchange(told_, {}))
      if (!stand && told.forced) nodes_.tell(robot, Type::run, {});
    if (!stand)
      for (const auto& [robot, speed] : set_points_) nodes_.set_wheels(robot, speed);
  }
  if (stand)
    for (const RobotId robot : info_.robots) see_to(robot, now);
}

// Tells a robot to stand until its wheels do, also over a line that loses messages, and halts a program that sets them
// again.
void AsebaLink::see_to(RobotId robot, TimePoint now) {
  if (!nodes_.is_here(robot)) {
    told_.erase(robot);
    return;
  }
  const auto [at, fresh] = told_.try_emplace(robot, Told{now, now, now, now});
  Told& told = at->second;
  const auto wheels = nodes_.wheels(robot);
  const bool drives = wheels && wheels->asked_at >= told.at && !wheels->stand;
  const bool stands = wheels && wheels->asked_at >= told.at && wheels->stand;
  if (fresh || drives || (!stands && now - told.said >= say_again)) {
    nodes_.set_wheels(robot, {});
    told.said = now;
  }
  if (drives) told.at = now;
  if (drives && !told.forced && now - told.first >= forced_after) {
    told.forced = nodes_.tell(robot, Type::pause, {}) && nodes_.set_wheels(robot, {});
    counters_.add("robots.program_halted");
    spdlog::warn("the program of robot {} drives despite the stop command; it is halted until robots resume", robot);
  }
  if (!fresh && now - told.asked < (stands ? wheels_each_later : wheels_each)) return;
  told.asked = now;
  nodes_.ask_wheels(robot, now);
}

std::vector<NotStanding> AsebaLink::not_standing() const {
  std::vector<NotStanding> out;
  if (!should_stand()) return out;
  for (const RobotId robot : info_.robots) {
    const auto told = told_.find(robot);
    const auto wheels = nodes_.wheels(robot);
    if (told == told_.end() || !nodes_.is_here(robot))
      out.push_back({robot, NotStanding::Why::not_told});
    else if (nodes_.is_twice(robot) || !wheels || wheels->asked_at < told->second.at)
      out.push_back({robot, NotStanding::Why::not_yet});
    else if (!wheels->stand)
      out.push_back({robot, NotStanding::Why::moving});
  }
  return out;
}

}  // namespace arkmesh::hal::aseba
