// What passes between robots' send timers and the infrared medium: the host offers, the medium finds out how the
// channel is at that moment, the robot acts on it in a turn of its own.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "hal/random.hpp"
#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {

// Where in a tick a robot's messages begin. With each message the place moves by chance, so that no two robots send
// together for ever. The robot's clock, with its ticks, stays as it is.
class SendTimer {
 public:
  // `spread`: the time between two messages is off by up to this share.
  SendTimer(double spread, hal::RandomStream chance) : spread_(spread), chance_(chance) {}

  // After the start of a tick, where the robot's clock comes at `clock_us`.
  std::int64_t at_us(std::int64_t clock_us) const {
    const std::int64_t at = clock_us + ahead_us_;
    return at < tick_us ? at : at - tick_us;
  }
  // A message has gone, `since_us` after the one before. By how many ticks the next one is later: -1, 0 or 1.
  int move(std::int64_t clock_us, std::int64_t since_us) {
    if (spread_ == 0) return 0;
    const double off_us = chance_.uniform(-spread_, spread_) * static_cast<double>(since_us);
    const std::int64_t by_us = std::clamp(static_cast<std::int64_t>(off_us), 1 - tick_us, tick_us - 1);
    const std::int64_t at = at_us(clock_us) + by_us;
    ahead_us_ = (ahead_us_ + by_us + tick_us) % tick_us;
    return at < 0 ? -1 : at >= tick_us ? 1 : 0;
  }

 private:
  double spread_;
  hal::RandomStream chance_;
  std::int64_t ahead_us_ = 0;  // of the robot's clock
};

// A robot would send when its timer comes.
struct Offer {
  int robot;
  std::int64_t at_us;        // after the start of the present tick
  std::uint16_t period = 0;  // kilo_tx_period
};

// What its moment brings. A robot that receives a message then gets none: it is not interrupted.
struct Outcome {
  int robot;
  // What it sends goes out undisturbed; it senses somebody else's light and backs off. With infrared = "argos": what it
  // says waits until it can go; that has gone.
  enum class Channel : std::uint8_t { free, busy, waits, gone } channel;
};

// What the robot does about it.
struct Reply {
  std::optional<Message> message;  // nothing: it has nothing to send
  std::uint32_t back_off_us = 0;   // of one that was busy: until it tries again
};

}  // namespace arkmesh::sim_ode
