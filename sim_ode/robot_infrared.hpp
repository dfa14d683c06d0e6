// infrared = "robot": who sends when, who hears it, who disturbs whom. Works in time order within each tick, with the
// message timing and carrier sense of the robots' firmware.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/random.hpp"
#include "sim_ode/contact_world.hpp"
#include "sim_ode/infrared_medium.hpp"
#include "sim_ode/infrared_reach.hpp"
#include "sim_ode/neighbour_grid.hpp"
#include "sim_ode/settings.hpp"
#include "sim_ode/simulated_arena.hpp"

namespace arkmesh::sim_ode {

class RobotInfrared final : public InfraredMedium {
 public:
  RobotInfrared(const Settings& settings, double width_m, double height_m, int robots, const std::string& lab,
                std::uint64_t seed);

  // From now on that source says when the overhead controller's light shines. It outlives the medium.
  void listen_to(const OverheadSource* source) { source_ = source; }
  // From now on these shapes block infrared. They outlive the medium and stand still within a tick; null: none.
  void set_blockers(const Shadows* shadows) { reach_.set_blockers(shadows); }
  // Factors on how far each robot is heard; at the beginning, or all are 1.
  void set_gains(std::vector<float> gains) { reach_.set_gains(std::move(gains)); }

  void overhead_sends(std::int64_t start_us) override;
  bool repeats(const Inbox::Overhead&) override { return false; }
  void begin_tick(std::int64_t number, const ContactWorld& world, std::span<const Offer> offers) override;
  std::optional<Outcome> next() override;
  void send(const Message& message) override;
  void back_off(std::uint32_t us) override;
  int soon() const override { return attempt_ + 4 < attempts_.size() ? attempts_[attempt_ + 4].robot : -1; }
  void end_tick(std::vector<Reception>& heard) override;
  bool receiving(int robot, std::int64_t at_us) const override {
    return (ears_[index(robot)].decoding >= 0 && ears_[index(robot)].energy_until_us > at_us) ||
           overhead_on_air(at_us, at_us + 1);
  }

 private:
  struct Sending {
    int robot;
    std::int64_t start_us, end_us;
    bool good_crc;
    Message message;
    std::size_t first_listener, listeners;  // in listeners_: who began to decode it
  };
  struct Ear {
    std::int64_t energy_until_us = 0;  // light of any sender in range
    std::int64_t sends_until_us = 0;
    std::int64_t retry_us = -1;  // of a robot that backed off; -1
    std::int64_t decoding = -1;  // number of the sending that a robot decodes, -1
  };
  struct Attempt {
    std::int64_t at_us;
    int robot;
    // robots in order at equal times
    bool operator>(const Attempt& other) const {
      return at_us != other.at_us ? at_us > other.at_us : robot > other.robot;
    }
  };
  static std::size_t index(int robot) { return static_cast<std::size_t>(robot); }
  bool overhead_on_air(std::int64_t from_us, std::int64_t to_us) const;
  void sort_attempts();
  void forget_ended();
  std::optional<Attempt> take_attempt();
  void fetch_ahead() const;
  void finish(const Sending& sending);

  Settings settings_;
  NeighbourGrid grid_;
  double grid_path_m_ = -1;  // ContactWorld::longest_path_m() when the grid was built
  hal::RandomStream chance_;
  InfraredReach reach_;
  std::vector<Ear> ears_;  // by robot
  // Sendings in order of start, which is order of end; those before ended_ are over. All of it moves forward between
  // ticks.
  std::vector<Sending> on_air_;
  std::vector<int> listeners_, near_;
  std::size_t ended_ = 0;
  std::int64_t first_number_ = 0;        // of on_air_.front()
  const ContactWorld* world_ = nullptr;  // of this tick, as are its bounds
  std::int64_t start_us_ = 0, end_us_ = 0;
  std::vector<Attempt> attempts_;         // of this tick, in order; counting_ and sorting_ help to get them there
  std::size_t attempt_ = 0;               // next one in attempts_
  Attempt now_{};                         // whose outcome was told last
  std::vector<Attempt> sorting_, again_;  // again_: a heap of those that backed off to a moment of this tick
  std::vector<std::uint32_t> counting_;
  std::vector<int> retrying_;
  const OverheadSource* source_ = nullptr;  // none: the arena's own composites
  std::deque<std::int64_t> overhead_us_;    // starts of the controller's latest packets
  std::vector<Reception> unsorted_;         // of this tick
  std::vector<std::uint32_t> first_of_;
};

}  // namespace arkmesh::sim_ode
