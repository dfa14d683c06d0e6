// The Aseba nodes of an emulator's robots, as they are behind one asebaswitch: what hosts say moves the simulated
// robots, which answer as if robot.aesl ran on them. Time is the arena's. Bytecode is not run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/counters.hpp"
#include "hal/platforms/aseba/protocol.hpp"
#include "sim_ode/simulated_arena.hpp"

namespace arkmesh::emulator {

class AsebaNodes {
 public:
  static constexpr hal::LabTime poll_each{50'000};

  // The arena outlives this. Nodes have the numbers of its robots.
  explicit AsebaNodes(sim_ode::SimulatedArena& arena);

  // From a host.
  void take(const hal::aseba::Message& message);
  // Lets robots stop that hear no host, and says what they say. `leds` by robot.
  void poll(std::span<const hal::Led> leds);
  // What goes to all hosts; at most 2 MB wait.
  std::vector<std::uint8_t> take_said();

  // Hands and faults. A dead robot's node is silent; switched on it begins anew.
  void set_power(int robot, bool on);
  void garbage(std::size_t bytes, std::uint64_t seed);
  void stall(hal::LabTime span);  // what nodes say comes after so long
  void cut() { ++cuts_; }
  int cuts() const { return cuts_; }  // of the line to hosts
  // run, pause, reset, to all robots. False: another word.
  bool say(std::string_view word);
  const hal::Counters& counters() const { return counters_; }

 private:
  struct Node {
    std::uint16_t number = 0;
    std::vector<std::int16_t> memory;
    bool powered = true, halted = false, stopped = false;  // stopped: because it was alone, since it last said so
    hal::Led shown = hal::Led::off, said = hal::Led::off;
  };
  void take_event(const hal::aseba::Message& message, std::span<const int> words);
  void take(Node& node, int robot, std::uint16_t type, std::span<const int> words);
  void describe(const Node& node);
  void say_here(Node& node);
  void say(const Node& node, hal::aseba::Message message);
  void command(hal::FleetCommand::Kind kind);
  void set_wheels(Node& node, int left, int right);

  sim_ode::SimulatedArena& arena_;
  std::vector<Node> nodes_;
  hal::LabTime heard_at_{0}, held_until_{0};
  bool running_ = false;
  int cuts_ = 0;
  std::vector<std::uint8_t> said_;
  hal::Counters counters_;
};

}  // namespace arkmesh::emulator
