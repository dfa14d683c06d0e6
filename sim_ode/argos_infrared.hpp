// infrared = "argos": the rules of ARGoS's plug-in for Kilobots, for what was written against them. Ticks of its own; a
// robot's message waits until it wins against those whose range it is in; up to four messages reach a robot in a tick,
// the overhead controller's first, which is said again each tick. No light: nothing blocks, spoils or shortens it.
// docs/model-truth.md has the table.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/random.hpp"
#include "sim_ode/infrared_medium.hpp"
#include "sim_ode/neighbour_grid.hpp"

namespace arkmesh::sim_ode {

class ArgosInfrared final : public InfraredMedium {
 public:
  ArgosInfrared(const Settings& settings, double width_m, double height_m, std::span<const RobotProfile> robots,
                const std::string& lab, std::uint64_t seed);

  void overhead_sends(std::int64_t) override {}  // takes nothing from robots
  bool repeats(const Inbox::Overhead& said) override;
  void begin_tick(std::int64_t number, const ContactWorld& world, std::span<const Offer> offers) override;
  std::optional<Outcome> next() override;
  void send(const Message& message) override { robots_[index(now_)].waiting = message; }
  void back_off(std::uint32_t) override {}  // no channel is ever busy
  int soon() const override { return -1; }
  void end_tick(std::vector<Reception>& heard) override;
  bool receiving(int, std::int64_t) const override { return false; }

 private:
  struct Robot {
    double range_m = 0;
    std::int64_t clock_tick = -1;    // of ARGoS, in which its clock was 0; -1: it has not run yet
    std::optional<Message> waiting;  // to be sent
    std::optional<Message> told;     // by the overhead controller
    int heard = 0;                   // messages in the present tick
    bool tries = false;
  };
  static std::size_t index(int robot) { return static_cast<std::size_t>(robot); }
  std::span<const int> near(int robot);
  double between_m(int a, int b) const;
  void ask();
  void run_tick();
  void hear(int robot, const Message& message, int distance_mm);
  void carry(int sender);

  const std::int64_t tick_us_;
  const bool ignore_conflicts_;
  const double loss_;
  NeighbourGrid grid_;
  double longest_m_ = 0;  // of all ranges
  hal::RandomStream chance_;
  std::vector<Robot> robots_;
  const ContactWorld* world_ = nullptr;  // of this tick of the robots, as are its bounds and the offers
  std::int64_t start_us_ = 0, end_us_ = 0;
  std::span<const Offer> offers_;
  std::int64_t ticks_ = 0;         // of ARGoS, so far
  std::int64_t to_ask_us_ = -1;    // robots are to be asked since that tick's start; -1: they were
  std::vector<Outcome> outcomes_;  // that are to be told, and how many were
  std::size_t told_ = 0;
  int now_ = 0;  // whose outcome was told last
  std::vector<int> winners_, near_;
  std::vector<Reception> heard_;  // in this tick of the robots
};

}  // namespace arkmesh::sim_ode
