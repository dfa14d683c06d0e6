// What robots hear from above: the simulated controller's composites, or each copy that a controller outside sends; and
// which robots miss it, because of chance or their place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/counters.hpp"
#include "hal/platforms/kilobot/message_registers.hpp"
#include "hal/random.hpp"
#include "hal/types.hpp"
#include "sim_ode/contact_world.hpp"
#include "sim_ode/host/turns/inbox.hpp"
#include "sim_ode/infrared_medium.hpp"
#include "sim_ode/settings.hpp"
#include "sim_ode/simulated_arena.hpp"

namespace arkmesh::sim_ode {

class OverheadAir {
 public:
  // All outlive it. `source`: a controller outside; null: the simulated one, which sends composites. Counts
  // `overhead.*` and `to_robots.lost.overhead`.
  OverheadAir(const Settings& settings, const hal::ArenaInfo& info, const ContactWorld& world, InfraredMedium& infrared,
              OverheadSource* source, const std::string& lab, std::uint64_t seed, hal::Counters& counters);

  bool is_outside() const { return source_ != nullptr; }
  // What is due `now`, to be heard in the tick that began at `tick_began_us`.
  // Returns what goes out beside it to wheels.
  hal::kilobot::MessageRegisters::SetPoints send_composite(hal::LabTime now, std::int64_t tick_began_us,
                                                           hal::kilobot::MessageRegisters& registers,
                                                           std::vector<Inbox::Overhead>& inbox);
  // What a controller outside has sent in the tick that ends `now`: every copy by itself, nothing assumed of
  // repetition.
  void hear(hal::LabTime now, std::vector<Inbox::Overhead>& inbox);
  // What it has sent since the last tick and up to `now`, which hear() gives to robots at the next one.
  std::span<const Transmission> sent_until(hal::LabTime now);
  // A robot was taken off the arena, where it hears nothing of a controller outside; one is back.
  void take_off() { ++off_arena_; }
  void put_back() { --off_arena_; }

 private:
  bool loses() const { return settings_.overhead_loss > 0 || settings_.air.overhead_loss_edge > 0; }
  double loss(std::size_t robot) const;
  void draw_missed(Inbox::Overhead& heard);
  void hide_from_others(Inbox::Overhead& heard, const std::vector<hal::RobotId>& robots) const;

  const Settings& settings_;
  const hal::ArenaInfo& info_;
  const ContactWorld& world_;
  InfraredMedium& infrared_;
  OverheadSource* source_;
  hal::Counters& counters_;
  hal::RandomStream loss_chance_;
  int off_arena_ = 0;               // robots
  std::vector<Transmission> sent_;  // since the last tick
};

}  // namespace arkmesh::sim_ode
