// Aseba nodes in a test's hand, and a line to them: they answer as a robot's firmware does, late or not at all if the
// test wishes, and keep what they were told.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/platforms/aseba/aseba_link.hpp"
#include "hal/platforms/aseba/protocol.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"
#include "hal/random.hpp"
#include "hal/time/wall_time.hpp"

namespace arkmesh::tests {

struct ScriptedNode {
  std::uint16_t number = 1;
  std::string name = "thymio-II";
  std::vector<std::pair<std::string, int>> variables{
      {"_id", 1}, {"event.args", 32}, {"motor.left.target", 1}, {"motor.right.target", 1}, {"prox.horizontal", 7}};
  bool describes = true, answers = true, obeys = true;  // obeys: its program leaves stopped wheels alone
  bool paused = false;                                  // its virtual machine
  std::chrono::milliseconds delay{0};
  std::vector<int> here;  // what its program answers to event_run, if it does: colour, stopped
  std::map<int, int> memory;
  std::vector<hal::aseba::Message> events;  // that it was told

  int address(const std::string& variable) const {
    int at = 0;
    for (const auto& [called, size] : variables) {
      if (called == variable) return at;
      at += size;
    }
    return -1;
  }
  int& at(const std::string& variable) { return memory[address(variable)]; }
};

// The far end of a line, shared with the stream.
struct ScriptedLine {
  explicit ScriptedLine(hal::WallTime& time) : wall(time) {}
  hal::WallTime& wall;
  bool plugged = true, hangs = false;  // hangs: what nodes say comes when it does not any more
  double loss = 0;                     // share of messages that are lost, each way
  hal::RandomStream chance{1, "line"};
  std::vector<ScriptedNode> nodes;
  hal::aseba::MessageReader reader;
  std::deque<std::pair<hal::TimePoint, std::vector<std::uint8_t>>> to_lab;  // what is on its way, and until when

  void say(const ScriptedNode& node, hal::aseba::Message message) {
    message.source = node.number;
    if (chance.uniform() < loss) return;
    to_lab.emplace_back(wall.now() + node.delay, hal::aseba::encode(message));
  }
  void raw(std::vector<std::uint8_t> bytes) { to_lab.emplace_back(wall.now(), std::move(bytes)); }
  ScriptedNode& node(std::uint16_t number) { return *std::ranges::find(nodes, number, &ScriptedNode::number); }

  void take(const hal::aseba::Message& message) {
    if (chance.uniform() < loss) return;
    for (ScriptedNode& node : nodes)
      if (node.answers) take(node, message);
  }

  void take(ScriptedNode& node, const hal::aseba::Message& message) {
    using namespace hal::aseba;
    const std::vector<int> words = words_of(message);
    if (message.type == list_nodes) say(node, make_message(node_present, {protocol_version}));
    if (message.is_event()) {
      node.events.push_back(message);
      if (message.type == event_run && !node.here.empty() && !node.paused)
        say(node, make_message(event_here, node.here));
      return;
    }
    if (words.empty() || words[0] != node.number) return;
    if (message.type == get_description && node.describes) describe(node);
    if (message.type == Type::pause) node.paused = true;
    if (message.type == Type::run || message.type == Type::reset) node.paused = false;
    if (message.type == set_variables)
      for (std::size_t i = 2; i < words.size(); ++i) node.memory[words[1] + static_cast<int>(i) - 2] = words[i];
    if (!node.obeys && !node.paused) node.at("motor.left.target") = 100;
    if (message.type != get_variables) return;
    std::vector<int> answer{words[1]};
    for (int i = 0; i < words[2]; ++i) answer.push_back(node.memory[words[1] + i]);
    say(node, make_message(hal::aseba::variables, answer));
  }

  void describe(const ScriptedNode& node) {
    using namespace hal::aseba;
    const auto text = [](const std::string& word) {
      std::vector<std::uint8_t> out{static_cast<std::uint8_t>(word.size())};
      out.insert(out.end(), word.begin(), word.end());
      return out;
    };
    Message first{.source = 0, .type = hal::aseba::description, .payload = text(node.name)};
    const auto numbers = make_message(0, {5, 1000, 32, 600, static_cast<int>(node.variables.size()), 0, 0});
    first.payload.insert(first.payload.end(), numbers.payload.begin(), numbers.payload.end());
    say(node, first);
    for (const auto& [called, size] : node.variables) {
      Message one = make_message(variable_named, {size});
      const auto word = text(called);
      one.payload.insert(one.payload.end(), word.begin(), word.end());
      say(node, one);
    }
  }
};

class ScriptedStream final : public hal::kilobot::ByteStream {
 public:
  explicit ScriptedStream(std::shared_ptr<ScriptedLine> line) : line_(std::move(line)) {}
  void open() override {
    open_ = line_->plugged;
    error_ = open_ ? "" : "there is no line";
  }
  State check() override {
    heard_.clear();
    if (open_ && !line_->plugged) {
      open_ = false;
      error_ = "the line was cut";
      line_->to_lab.clear();
      line_->reader = {};
    }
    // what is late keeps nobody else's
    for (auto next = line_->to_lab.begin();
         open_ && !line_->hangs && next != line_->to_lab.end() && heard_.size() < 4096;) {
      if (next->first > line_->wall.now()) {
        ++next;
        continue;
      }
      heard_.insert(heard_.end(), next->second.begin(), next->second.end());
      next = line_->to_lab.erase(next);
    }
    return open_ ? State::open : State::closed;
  }
  std::span<const std::uint8_t> heard() const override { return heard_; }
  std::size_t write(std::span<const std::uint8_t> bytes) override {
    const auto some = bytes.first(std::min<std::size_t>(bytes.size(), 100));  // as the system takes them: some
    for (const auto& message : line_->reader.read(some)) line_->take(message);
    return some.size();
  }
  std::size_t waiting_bytes() override { return 0; }
  const std::string& error() const override { return error_; }

 private:
  std::shared_ptr<ScriptedLine> line_;
  bool open_ = false;
  std::string error_;
  std::vector<std::uint8_t> heard_;
};

// Time that passes when somebody waits.
class PassingTime final : public hal::WallTime {
 public:
  hal::TimePoint now() override { return now_; }
  void wait_until(hal::TimePoint then) override { now_ = std::max(now_, then); }

 private:
  hal::TimePoint now_ = hal::TimePoint(std::chrono::hours(1));
};

}  // namespace arkmesh::tests
