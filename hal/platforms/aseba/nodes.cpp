#include "hal/platforms/aseba/nodes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "hal/arenas/robot_words.hpp"

namespace arkmesh::hal::aseba {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds open_each = 250ms, list_each = 300ms, describe_each = 5s, answer_within = 10s;
constexpr std::chrono::milliseconds rest_within = 1s;  // of a message whose beginning has come
constexpr std::chrono::milliseconds twice_for = 10s;   // after it was last noticed
constexpr std::size_t most_waiting_bytes = 16'384, most_events = 1000, most_strangers = 8;
constexpr std::uint64_t most_unanswered = Nodes::silent_for / list_each + 1;  // questions who is there
constexpr int most_between_wheels = 64;

}  // namespace

Nodes::Nodes(std::vector<Connection> connections, std::vector<RobotId> robots, Make make, Counters& counters)
    : robots_(std::move(robots)), make_(std::move(make)), counters_(counters) {
  for (Connection& connection : connections) lines_.emplace_back().connection = std::move(connection);
}

void Nodes::poll(TimePoint now) {
  for (Line& line : lines_) serve(line, now);
  std::vector<RobotId> silent;
  for (auto& [robot, node] : nodes_) {
    if (now - node.heard_at > silent_for) silent.push_back(robot);
    if (node.ready || !node.lacks.empty()) continue;
    if (node.description_asked && now - *node.description_asked < describe_each) continue;
    if (put(lines_[node.line], make_message(get_description, {node.number, protocol_version})))
      node.description_asked = now;
  }
  for (const RobotId robot : silent) forget(robot, "does not answer");
  for (Line& line : lines_) write(line);
}

void Nodes::serve(Line& line, TimePoint now) {
  if (line.state == ByteStream::State::closed) {
    if (now < line.try_at) return;
    line.try_at = now + open_each;
    line.connection.stream->open();
  }
  const ByteStream::State before = std::exchange(line.state, line.connection.stream->check());
  if (line.state == ByteStream::State::open && before != ByteStream::State::open) opened(line, now);
  const std::span<const std::uint8_t> bytes = line.connection.stream->heard();
  const auto number = static_cast<std::size_t>(&line - lines_.data());
  // garbage that looks like a long message's beginning swallows those behind it for so long only
  std::vector<Message> messages = line.reader.read(bytes);
  if (messages.empty() && line.reader.waits() && now - line.read_at > rest_within) messages = line.reader.give_up();
  if (!messages.empty() || !line.reader.waits()) line.read_at = now;
  for (const Message& message : messages) hear(number, message, now);
  if (const std::uint64_t damaged = line.reader.damaged_bytes(); damaged > line.damaged) {
    counters_.add("aseba.damaged_bytes", damaged - std::exchange(line.damaged, damaged));
    if (!std::exchange(line.said_damaged, true))
      spdlog::warn("{}: received bytes that belong to no Aseba message; they are skipped", line.connection.name);
  }
  if (line.state == ByteStream::State::closed) return lost(line, now);
  if (line.state != ByteStream::State::open || now < line.list_at) return;
  line.list_at = now + list_each;
  if (put(line, make_message(list_nodes, {protocol_version}))) ++line.lists;
}

void Nodes::opened(Line& line, TimePoint now) {
  ++openings_;
  counters_.add("aseba.line_opened");
  line.out.clear();
  line.lists = 0;
  line.list_at = now;
  line.said_damaged = false;
  if (std::exchange(line.said_lost, false)) spdlog::info("{} is open", line.connection.name);
}

void Nodes::lost(Line& line, TimePoint now) {
  line.reader.cut();
  line.try_at = std::max(line.try_at, now);
  std::vector<RobotId> gone;
  for (const auto& [robot, node] : nodes_)
    if (&lines_[node.line] == &line) gone.push_back(robot);
  for (const RobotId robot : gone) forget(robot, "is gone with its connection");
  if (std::exchange(line.said_lost, true)) return;
  counters_.add("aseba.line_lost");
  spdlog::warn("{}; trying again", line.connection.stream->error());
}

void Nodes::write(Line& line) {
  if (line.state != ByteStream::State::open || line.out.empty()) return;
  const std::size_t written = line.connection.stream->write(line.out);
  line.out.erase(line.out.begin(), line.out.begin() + static_cast<std::ptrdiff_t>(written));
}

bool Nodes::put(Line& line, const Message& message) {
  if (line.state != ByteStream::State::open) return false;
  const std::vector<std::uint8_t> bytes = encode(message);
  if (line.out.size() + bytes.size() > most_waiting_bytes) {
    counters_.add("aseba.dropped.line_busy");
    return false;
  }
  line.out.insert(line.out.end(), bytes.begin(), bytes.end());
  return true;
}

// A switch passes on what another program says.
void Nodes::hear_other(Line& line, const Message& message) {
  if (message.type == list_nodes) ++line.lists;
  if (!message.is_event() || (message.type == event_run && words_of(message) == std::vector<int>{only_answer})) return;
  counters_.add("aseba.other_host");
  if (!std::exchange(line.said_other, true))
    spdlog::warn("{}: another program sends events to these robots, too; if it is a lab, end one of the two",
                 line.connection.name);
}

std::optional<RobotId> Nodes::robot_of(const Line& line, const Message& message) {
  const std::uint16_t number = message.source;
  if (line.connection.robot) return line.connection.robot;
  if (std::ranges::binary_search(robots_, RobotId{number})) return number;
  if (message.type == node_present && strangers_.size() < most_strangers &&
      strangers_.emplace(line.connection.name, number).second) {
    counters_.add("nodes.refused.unknown");
    spdlog::warn("{}: node {} is not one of this lab's robots ({}); it is ignored", line.connection.name, number,
                 in_words(robots_));
  }
  return {};
}

void Nodes::hear(std::size_t line, const Message& message, TimePoint now) {
  if (message.source == 0) return hear_other(lines_[line], message);
  if (message.type >= reset) return;
  const auto robot = robot_of(lines_[line], message);
  if (!robot) return;
  auto found = nodes_.find(*robot);
  if (found == nodes_.end()) {
    if (message.type != node_present) return;
    found = nodes_.try_emplace(*robot).first;
    found->second.line = line;
    found->second.number = message.source;
    found->second.found_at = now;
  }
  Node& node = found->second;
  if (node.line != line || node.number != message.source) {
    node.twice_at = now;
    if (!said_twice_.insert(*robot).second) return;
    counters_.add("nodes.twice");
    return spdlog::warn("robot {} is node {} of {} and node {} of {}; the second is ignored", *robot, node.number,
                        lines_[node.line].connection.name, message.source, lines_[line].connection.name);
  }
  node.heard_at = now;
  if (message.is_event()) {
    if (events_.size() < most_events)
      events_.emplace_back(*robot, message);
    else
      counters_.add("from_robots.dropped.too_many");
  } else if (message.type == node_present) {
    count_present(*robot, node, now);
  } else if (message.type == description || message.type == variable_named) {
    if (!node.ready && node.lacks.empty()) learn(*robot, node, message);
  } else if (message.type == variables) {
    take_wheels(*robot, node, message, now);
  } else if (message.type >= out_of_bounds && message.type <= event_killed) {
    counters_.add("robots.program_failed");
    spdlog::warn("the program of robot {} failed: {}", *robot,
                 message.type == out_of_bounds      ? "an index is outside its array"
                 : message.type == division_by_zero ? "division by zero"
                                                    : "an event arrived before the previous one was handled");
  }
}

// A node answers each question once: who answers oftener is two. Questions that it did not answer long ago are lost;
// but when it is found, a switch that hung may pass on all of them at once.
void Nodes::count_present(RobotId robot, Node& node, TimePoint now) {
  const Line& line = lines_[node.line];
  const std::uint64_t answered = ++node.presents + most_unanswered;
  if (now - node.found_at > silent_for)
    node.lists_before = std::max(node.lists_before, line.lists - std::min(line.lists, answered));
  if (node.presents <= line.lists - node.lists_before + 2) return;
  node.presents = 0;
  node.lists_before = line.lists - std::min(line.lists, most_unanswered);
  node.twice_at = now;
  if (!said_twice_.insert(robot).second) return;
  counters_.add("nodes.twice");
  spdlog::warn("{}: two nodes have the number {}: renumber one of them", line.connection.name, node.number);
}

void Nodes::learn(RobotId robot, Node& node, const Message& message) {
  if (!node.description.take(message)) return counters_.add("nodes.refused.description");
  if (!node.description.complete()) return;
  for (const std::string& wheel : make_.wheels)
    if (!node.description.find(wheel)) node.lacks += (node.lacks.empty() ? "" : " and ") + wheel;
  const std::string& line = lines_[node.line].connection.name;
  if (!node.lacks.empty() || span_of_wheels(node).second > most_between_wheels) {
    counters_.add("nodes.refused.variables");
    if (node.lacks.empty()) node.lacks = make_.wheels[0] + " near " + make_.wheels[1];
    return spdlog::warn("robot {} is node {} ({}) of {}, which has no {}: it is no {}", robot, node.number,
                        node.description.name(), line, node.lacks, make_.name);
  }
  node.ready = true;
  counters_.add("nodes.found");
  if (!met_.insert(robot).second) restarted_.insert(robot);
  spdlog::info("robot {} is node {} ({}) of {}", robot, node.number, node.description.name(), line);
}

void Nodes::take_wheels(RobotId robot, Node& node, const Message& message, TimePoint now) {
  if (!node.ready || !node.wheels_asked) return;
  const auto [start, count] = span_of_wheels(node);
  const std::vector<int> words = words_of(message);
  if (words.size() != static_cast<std::size_t>(1 + count) || words[0] != start) return;  // another program's
  node.wheels = {*node.wheels_asked, true};
  for (const std::string& wheel : make_.wheels)
    if (words[static_cast<std::size_t>(1 + node.description.find(wheel)->start - start)] != 0)
      node.wheels->stand = false;
  const auto took = now - *node.wheels_asked;
  node.wheels_asked.reset();
  if (took <= late_after) return;
  counters_.add("nodes.late");
  if (!std::exchange(node.said_late, true))
    spdlog::warn("robot {} answers {:.1f} s late", robot, std::chrono::duration<double>(took).count());
}

void Nodes::forget(RobotId robot, const char* why) {
  const auto found = nodes_.find(robot);
  if (found->second.ready) {
    counters_.add("nodes.lost");
    spdlog::warn("robot {}, node {} of {}, {}", robot, found->second.number, lines_[found->second.line].connection.name,
                 why);
  }
  nodes_.erase(found);
}

// The first variable that holds a wheel's set point, and how many words from it to the end of the other.
std::pair<int, int> Nodes::span_of_wheels(const Node& node) const {
  const auto left = node.description.find(make_.wheels[0]), right = node.description.find(make_.wheels[1]);
  if (!left || !right) return {0, 0};
  return {std::min(left->start, right->start), std::abs(left->start - right->start) + 1};
}

bool Nodes::is_here(RobotId robot) const {
  const auto found = nodes_.find(robot);
  return found != nodes_.end() && found->second.ready;
}

bool Nodes::is_twice(RobotId robot) const {
  const auto found = nodes_.find(robot);
  return found != nodes_.end() && found->second.twice_at &&
         found->second.heard_at - *found->second.twice_at < twice_for;
}

std::string Nodes::missing() const {
  std::vector<std::string> out;
  std::vector<RobotId> absent;
  for (const RobotId robot : robots_) {
    const auto found = nodes_.find(robot);
    if (found == nodes_.end()) {
      absent.push_back(robot);
    } else if (const Node& node = found->second; is_twice(robot)) {
      out.push_back(fmt::format("there are two nodes for robot {}; give one another number", robot));
    } else if (!node.lacks.empty()) {
      out.push_back(fmt::format("node {} of {} ({}) has no {}, so it is no {}", node.number,
                                lines_[node.line].connection.name, node.description.name(), node.lacks, make_.name));
    } else if (!node.ready) {
      out.push_back(
          fmt::format("node {} of {} does not describe itself", node.number, lines_[node.line].connection.name));
    }
  }
  if (!absent.empty()) out.push_back(fmt::format("no node answers for robots {}", in_words(absent)));
  for (const Line& line : lines_)
    if (line.state != ByteStream::State::open && !line.connection.stream->error().empty())
      out.push_back(line.connection.stream->error());
  return fmt::format("{}", fmt::join(out, "; "));
}

std::vector<std::string> Nodes::described() const {
  std::vector<std::string> out;
  for (const auto& [robot, node] : nodes_)
    if (node.ready)
      out.push_back(fmt::format("robot {}: node {} of {}, {} with {} variables", robot, node.number,
                                lines_[node.line].connection.name, node.description.name(),
                                node.description.all().size()));
  return out;
}

bool Nodes::tell(RobotId robot, std::uint16_t type, std::vector<int> words) {
  if (!is_here(robot)) return false;
  const Node& node = nodes_.at(robot);
  words.insert(words.begin(), node.number);
  return put(lines_[node.line], make_message(type, words));
}

bool Nodes::set_wheels(RobotId robot, const SetPoint& speed) {
  if (!is_here(robot)) return false;
  const Description& about = nodes_.at(robot).description;
  const int left = about.find(make_.wheels[0])->start, right = about.find(make_.wheels[1])->start;
  const auto target = [&](int mm_s) { return static_cast<int>(std::lround(mm_s * make_.per_mm_s)); };
  const int left_target = target(speed.left_mm_s), right_target = target(speed.right_mm_s);
  // in one message, so that none is lost alone
  if (right == left + 1) return tell(robot, set_variables, {left, left_target, right_target});
  return tell(robot, set_variables, {left, left_target}) && tell(robot, set_variables, {right, right_target});
}

void Nodes::tell_all(std::uint16_t event, std::initializer_list<int> words) {
  for (Line& line : lines_) put(line, make_message(event, words));
}

void Nodes::ask_wheels(RobotId robot, TimePoint now) {
  if (!is_here(robot)) return;
  Node& node = nodes_.at(robot);
  if (node.wheels_asked && now - *node.wheels_asked < answer_within) return;
  const auto [start, count] = span_of_wheels(node);
  if (tell(robot, get_variables, {start, count})) node.wheels_asked = now;
}

std::optional<Nodes::Wheels> Nodes::wheels(RobotId robot) const {
  const auto found = nodes_.find(robot);
  return found == nodes_.end() ? std::nullopt : found->second.wheels;
}

}  // namespace arkmesh::hal::aseba
