// The nodes at the other ends of all lines: finds them, reads their descriptions, notices who is gone, back, late, or
// there twice, and carries messages both ways. Knows a robot's number, and nothing of labs. Time is the caller's.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "hal/counters.hpp"
#include "hal/platforms/aseba/protocol.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"
#include "hal/robot/set_point.hpp"
#include "hal/time/wall_time.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal::aseba {

using kilobot::ByteStream;

// A way to nodes: to one, or to several behind a switch or a radio.
struct Connection {
  std::string name;              // as people call it
  std::optional<RobotId> robot;  // its only node is this robot, whatever its number; else nodes' numbers are robots'
  std::unique_ptr<ByteStream> stream;
};

// What a make of robots calls the set points of its wheels, and its unit of them.
struct Make {
  std::string name;
  std::array<std::string, 2> wheels;  // left, right
  double per_mm_s = 1;
};

class Nodes {
 public:
  // Until a node counts as gone, and until an answer counts as late.
  static constexpr std::chrono::milliseconds silent_for{4000}, late_after{1000};

  // `robots`: who is expected, ascending. `counters` outlives this.
  Nodes(std::vector<Connection> connections, std::vector<RobotId> robots, Make make, Counters& counters);

  // Opens, reads, writes, asks, as far as that is due: call it each 10 ms. Never blocks.
  void poll(TimePoint now);

  // Its node is there, and has what this make has.
  bool is_here(RobotId robot) const;
  // Its node is there twice, so that its answers tell nothing.
  bool is_twice(RobotId robot) const;
  // Why robots cannot be used, a clause for each reason; empty: all can.
  std::string missing() const;
  // A line for each robot that can be used.
  std::vector<std::string> described() const;

  // These are false when the node is not there, or its line takes no more. The message's first word is the node's
  // number.
  bool tell(RobotId robot, std::uint16_t type, std::vector<int> words);
  bool set_wheels(RobotId robot, const SetPoint& speed);
  // An event on each line that is open.
  void tell_all(std::uint16_t event, std::initializer_list<int> words);

  // Whether its wheels' set points are 0. One question at a time: no effect while the last one was not answered.
  void ask_wheels(RobotId robot, TimePoint now);
  struct Wheels {
    TimePoint asked_at{};
    bool stand = false;
  };
  // The newest answer.
  std::optional<Wheels> wheels(RobotId robot) const;

  // Events from robots since the last call, with the robot as source; at most 1000.
  std::vector<std::pair<RobotId, Message>> take_events() { return std::exchange(events_, {}); }
  // Robots whose node began anew, or may have, since the last call.
  std::set<RobotId> take_restarted() { return std::exchange(restarted_, {}); }
  // Times that a line was opened.
  std::uint64_t openings() const { return openings_; }

 private:
  struct Line {
    Connection connection;
    MessageReader reader;
    ByteStream::State state = ByteStream::State::closed;
    TimePoint try_at = TimePoint::min(), list_at{}, read_at{};
    std::vector<std::uint8_t> out;  // not written yet
    std::uint64_t lists = 0;        // questions who is there, ours and those of other programs
    std::uint64_t damaged = 0;
    bool said_lost = false, said_damaged = false, said_other = false;
  };
  struct Node {
    std::size_t line = 0;
    std::uint16_t number = 0;
    TimePoint found_at{}, heard_at{};
    std::optional<TimePoint> description_asked, wheels_asked, twice_at;
    std::uint64_t lists_before = 0, presents = 0;  // of its line's, and its answers since
    Description description;
    bool ready = false, said_late = false;
    std::string lacks;  // a variable, so that it is none of this make
    std::optional<Wheels> wheels;
  };

  void serve(Line& line, TimePoint now);
  void opened(Line& line, TimePoint now);
  void lost(Line& line, TimePoint now);
  void write(Line& line);
  bool put(Line& line, const Message& message);
  void hear_other(Line& line, const Message& message);
  void hear(std::size_t line, const Message& message, TimePoint now);
  std::optional<RobotId> robot_of(const Line& line, const Message& message);
  void count_present(RobotId robot, Node& node, TimePoint now);
  void learn(RobotId robot, Node& node, const Message& message);
  void take_wheels(RobotId robot, Node& node, const Message& message, TimePoint now);
  void forget(RobotId robot, const char* why);
  std::pair<int, int> span_of_wheels(const Node& node) const;

  const std::vector<RobotId> robots_;
  const Make make_;
  Counters& counters_;
  std::vector<Line> lines_;
  std::map<RobotId, Node> nodes_;
  std::set<RobotId> met_, said_twice_, restarted_;
  std::set<std::pair<std::string, std::uint16_t>> strangers_;  // line and number, as said
  std::vector<std::pair<RobotId, Message>> events_;
  std::uint64_t openings_ = 0;
};

}  // namespace arkmesh::hal::aseba
