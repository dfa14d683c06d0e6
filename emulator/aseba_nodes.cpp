#include "emulator/aseba_nodes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "hal/platforms/aseba/aseba_link.hpp"
#include "hal/random.hpp"
#include "hal/robot/set_point.hpp"
#include "hal/robot/thymio.hpp"

namespace arkmesh::emulator {
namespace {

using namespace hal::aseba;
using namespace std::chrono_literals;

constexpr hal::LabTime alone_after = 1500ms;  // as robot.aesl
constexpr std::size_t most_said = 2 << 20;

// Some of a Thymio's variables, in an order of ours: hosts find them by name.
constexpr std::array<std::pair<std::string_view, int>, 7> variables_of_node{{{"_id", 1},
                                                                             {"event.source", 1},
                                                                             {"event.args", 32},
                                                                             {"_productId", 1},
                                                                             {"prox.horizontal", 7},
                                                                             {"motor.left.target", 1},
                                                                             {"motor.right.target", 1}}};
constexpr std::size_t words_of_node = 44, first_prox = 35, left_wheel = 42;

std::vector<std::uint8_t> text(std::string_view word) {
  std::vector<std::uint8_t> out{static_cast<std::uint8_t>(word.size())};
  out.insert(out.end(), word.begin(), word.end());
  return out;
}

}  // namespace

AsebaNodes::AsebaNodes(sim_ode::SimulatedArena& arena) : arena_(arena) {
  for (const hal::RobotId robot : arena.info().robots) {
    Node& node = nodes_.emplace_back();
    node.number = static_cast<std::uint16_t>(robot);
    node.memory.assign(words_of_node, 0);
    node.memory[0] = static_cast<std::int16_t>(node.number);
  }
}

void AsebaNodes::take(const Message& message) {
  const std::vector<int> words = words_of(message);
  if (message.is_event()) return take_event(message, words);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    if (!node.powered) continue;
    if (message.type == list_nodes)
      say(node, make_message(node_present, {protocol_version}));
    else if (!words.empty() && static_cast<std::uint16_t>(words[0]) == node.number)
      take(node, static_cast<int>(i), message.type, std::span(words).subspan(1));
  }
}

void AsebaNodes::take_event(const Message& message, std::span<const int> words) {
  if (message.type == event_run && words.size() == 1) {
    heard_at_ = arena_.clock().now();
    // said again: a robot that was switched on meanwhile waits for it
    if (words[0] == run_program) command(hal::FleetCommand::Kind::run);
    if (words[0] == stand_still && running_) command(hal::FleetCommand::Kind::pause);
    for (Node& node : nodes_) {
      if (!node.powered || node.halted) continue;
      if (words[0] == stand_still) set_wheels(node, 0, 0);
      say_here(node);
    }
  } else if (message.type == event_word && words.size() == 3) {
    const auto node = std::ranges::find(nodes_, static_cast<std::uint16_t>(words[0]), &Node::number);
    if (node == nodes_.end() || !node->powered || node->halted) return;
    const hal::ToRobot word{.robot = node->number,
                            .slot = static_cast<std::uint8_t>(words[1] % hal::set_point_slot),
                            .kind = static_cast<std::uint8_t>(words[1]),
                            .value = static_cast<std::uint16_t>(words[2])};
    arena_.robots().offer({&word, 1});
  } else {
    counters_.add("nodes.ignored.event");
  }
}

void AsebaNodes::take(Node& node, int robot, std::uint16_t type, std::span<const int> words) {
  const std::size_t start = words.empty() ? 0 : static_cast<std::uint16_t>(words[0]);
  if (type == get_description) {
    describe(node);
  } else if (type == get_variables && words.size() == 2 && words[1] >= 0 &&
             start + static_cast<std::size_t>(words[1]) <= node.memory.size()) {
    for (int sensor = 0; const auto reading = arena_.prox(robot, sensor); ++sensor)
      node.memory[first_prox + static_cast<std::size_t>(sensor)] = *reading;
    std::vector<int> answer{words[0]};
    for (int i = 0; i < words[1]; ++i) answer.push_back(node.memory[start + static_cast<std::size_t>(i)]);
    say(node, make_message(hal::aseba::variables, answer));
  } else if (type == set_variables && !words.empty() && start + words.size() - 1 <= node.memory.size()) {
    for (std::size_t i = 1; i < words.size(); ++i) node.memory[start + i - 1] = static_cast<std::int16_t>(words[i]);
    if (start <= left_wheel + 1 && start + words.size() - 1 > left_wheel)
      set_wheels(node, node.memory[left_wheel], node.memory[left_wheel + 1]);
  } else if (type == reset) {
    arena_.set_power(robot, false);
    arena_.set_power(robot, true);
    set_power(robot, true);
    if (running_) command(hal::FleetCommand::Kind::run);
  } else if (type == pause || type == run) {
    node.halted = type == pause;
  } else {
    counters_.add("nodes.refused.message");
  }
}

void AsebaNodes::describe(const Node& node) {
  Message first{.source = 0, .type = description, .payload = text("thymio-II")};
  // bytecode, stack, memory, variables, events, functions
  const Message numbers =
      make_message(0, {protocol_version, 0, 0, static_cast<int>(words_of_node), variables_of_node.size(), 0, 0});
  first.payload.insert(first.payload.end(), numbers.payload.begin(), numbers.payload.end());
  say(node, first);
  for (const auto& [name, size] : variables_of_node) {
    Message one = make_message(variable_named, {size});
    const auto named = text(name);
    one.payload.insert(one.payload.end(), named.begin(), named.end());
    say(node, one);
  }
}

void AsebaNodes::poll(std::span<const hal::Led> leds) {
  const bool alone = arena_.clock().now() - heard_at_ > alone_after;
  if (alone && running_) command(hal::FleetCommand::Kind::pause);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    node.shown = leds[i];
    if (!node.powered || node.halted) continue;
    if (alone && (node.memory[left_wheel] != 0 || node.memory[left_wheel + 1] != 0)) {
      node.stopped = true;
      set_wheels(node, 0, 0);
    }
    if (node.shown != node.said) say_here(node);
  }
  for (const hal::FromRobot& said : arena_.robots().heard()) {
    const auto node = std::ranges::find(nodes_, static_cast<std::uint16_t>(said.robot), &Node::number);
    if (node != nodes_.end() && node->powered) say(*node, make_message(event_says, {said.kind, said.value}));
  }
}

void AsebaNodes::say_here(Node& node) {
  node.said = node.shown;
  say(node, make_message(event_here, {static_cast<int>(node.shown), std::exchange(node.stopped, false) ? 1 : 0}));
}

void AsebaNodes::say(const Node& node, Message message) {
  message.source = node.number;
  const std::vector<std::uint8_t> bytes = encode(message);
  if (said_.size() + bytes.size() > most_said) return counters_.add("nodes.dropped.unread");
  said_.insert(said_.end(), bytes.begin(), bytes.end());
}

std::vector<std::uint8_t> AsebaNodes::take_said() {
  if (arena_.clock().now() < held_until_) return {};
  return std::exchange(said_, {});
}

void AsebaNodes::set_power(int robot, bool on) {
  Node& node = nodes_[static_cast<std::size_t>(robot)];
  node = {.number = node.number, .memory = std::vector<std::int16_t>(words_of_node, 0), .powered = on};
  node.memory[0] = static_cast<std::int16_t>(node.number);
}

void AsebaNodes::garbage(std::size_t bytes, std::uint64_t seed) {
  hal::RandomStream chance(seed, "room/nodes", static_cast<std::uint64_t>(arena_.clock().now().count()));
  for (; bytes > 0 && said_.size() < most_said; --bytes) said_.push_back(static_cast<std::uint8_t>(chance.below(256)));
}

void AsebaNodes::stall(hal::LabTime span) {
  held_until_ = arena_.clock().now() + span;
}

bool AsebaNodes::say(std::string_view word) {
  if (word == "run" || word == "pause") {
    heard_at_ = word == "run" ? hal::LabTime::max() / 2 : heard_at_;
    command(word == "run" ? hal::FleetCommand::Kind::run : hal::FleetCommand::Kind::pause);
    return true;
  }
  if (word == "reset") command(hal::FleetCommand::Kind::reset);
  return word == "reset";
}

void AsebaNodes::command(hal::FleetCommand::Kind kind) {
  arena_.robots().command({.kind = kind});
  running_ = kind == hal::FleetCommand::Kind::run;
}

void AsebaNodes::set_wheels(Node& node, int left, int right) {
  node.memory[left_wheel] = static_cast<std::int16_t>(left);
  node.memory[left_wheel + 1] = static_cast<std::int16_t>(right);
  const auto mm_s = [](int target) { return static_cast<int>(std::lround(target / hal::thymio_target_per_mm_s)); };
  const hal::ToRobot word = hal::to_robot(node.number, {mm_s(left), mm_s(right)});
  arena_.robots().offer({&word, 1});
}

}  // namespace arkmesh::emulator
