// Robots' infrared: who sends when, who hears it. Knows no programs: it takes offers and says what comes of them. Whose
// rules hold, a robot's or ARGoS's, is chosen in make_infrared().
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim_ode/contact_world.hpp"
#include "sim_ode/deaf_pairs.hpp"
#include "sim_ode/host/turns/inbox.hpp"
#include "sim_ode/host/turns/send_timer.hpp"
#include "sim_ode/settings.hpp"
#include "sim_ode/simulated_arena.hpp"

namespace arkmesh::sim_ode {

struct Shadows;

class InfraredMedium {
 public:
  explicit InfraredMedium(int robots) : pairs_(robots) {}
  virtual ~InfraredMedium() = default;

  // The overhead controller sends from `start_us` on, over everything; it senses nothing.
  virtual void overhead_sends(std::int64_t start_us) = 0;
  // What it says to robots, if the medium says it to them, each tick until something else is said to them. False: they
  // hear it once, without the medium.
  virtual bool repeats(const Inbox::Overhead& said) = 0;

  // Tick `number` begins: robots whose timers come in it. `world` stands still until the tick's end.
  virtual void begin_tick(std::int64_t number, const ContactWorld& world, std::span<const Offer> offers) = 0;
  // What comes of the next offer, in time order; nothing when the tick is over. The robot's reply is due before the
  // next call: send(), back_off() or nothing.
  virtual std::optional<Outcome> next() = 0;
  // The robot of the last outcome sends, unless that has gone. Its channel was not busy.
  virtual void send(const Message& message) = 0;
  // It tries again after so long, perhaps in a later tick; its channel was busy.
  virtual void back_off(std::uint32_t us) = 0;
  // The robot whose turn to reply comes a little later, so that its memory can be fetched; -1.
  virtual int soon() const = 0;
  // After the last outcome: what robots received in this tick. Ascending by robot, then in time order.
  virtual void end_tick(std::vector<Reception>& heard) = 0;

  // Whether a message arrives at a robot at this time, at or after the end of the last tick that ran.
  virtual bool receiving(int robot, std::int64_t at_us) const = 0;

  struct Totals {
    std::uint64_t sent = 0, received = 0;
    std::uint64_t bad_crc = 0;       // messages sent with a wrong checksum: nobody hears them
    std::uint64_t for_firmware = 0;  // messages sent of types above 127, which no program hears
    std::uint64_t spoiled = 0;       // receptions lost to another sender
    std::uint64_t lost = 0;          // receptions lost by chance
    std::uint64_t crowded = 0;       // receptions lost because as many as a tick allows had come
    std::uint64_t backed_off = 0;    // attempts put off because of somebody else's message
  };
  const Totals& totals() const { return totals_; }
  DeafPairs::Totals pairs() const { return pairs_.totals(); }

 protected:
  Totals totals_;
  DeafPairs pairs_;
};

// By settings.infrared. `source` says when the overhead controller's light shines, null: the arena's own composites;
// shapes block a robot's infrared, null: none do. Both outlive the medium; shapes stand still within a tick.
std::unique_ptr<InfraredMedium> make_infrared(const Settings& settings, double width_m, double height_m,
                                              std::span<const RobotProfile> robots, const std::string& lab,
                                              std::uint64_t seed, const Shadows* shapes = nullptr,
                                              const OverheadSource* source = nullptr);

}  // namespace arkmesh::sim_ode
