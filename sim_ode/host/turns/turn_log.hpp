// What happened to each robot's program, as bytes in order: what it was called with, what it asked the library, what it
// got, and what its memory held at each pause. Enough to do it all again elsewhere, as sim_ode/silicon/emulator.c does,
// which lists the records.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::sim_ode {

class TurnLog {
 public:
  explicit TurnLog(int robots) : robots_(static_cast<std::size_t>(robots)) {}

  // A record: its letter and its values, little endian.
  template <class... Values>
  void put(int robot, char letter, Values... values) {
    if (only_ >= 0 && robot != only_) return;
    std::string& log = of(robot).log;
    log += letter;
    (append(log, &values, sizeof values), ...);
  }
  void put_bytes(int robot, const void* bytes, std::size_t size) {
    if (only_ < 0 || robot == only_) append(of(robot).log, bytes, size);
  }
  // What has changed of a robot's memory since the last time: runs of bytes, (offset, size, bytes), then a size of 0.
  void put_memory(int robot, const char* begin, const char* end) {
    if (only_ >= 0 && robot != only_) return;
    auto& [log, seen] = of(robot);
    const auto size = static_cast<std::size_t>(end - begin);
    seen.resize(size);
    for (std::size_t at = 0; at < size; ++at) {
      if (seen[at] == begin[at]) continue;
      std::size_t past = at + 1;
      while (past < size && past - at < 60000 && seen[past] != begin[past]) ++past;
      const auto where = static_cast<std::uint16_t>(at), length = static_cast<std::uint16_t>(past - at);
      append(log, &where, 2), append(log, &length, 2), append(log, begin + at, length);
      std::memcpy(&seen[at], begin + at, length);
      at = past - 1;
    }
    log.append(4, '\0');
  }
  // What was written of other robots is forgotten, and what comes of them is not written.
  void keep_only(int robot) {
    only_ = robot;
    for (int other = 0; other < robots(); ++other)
      if (other != robot) of(other) = {};
  }
  std::string_view of_robot(int robot) const { return robots_[static_cast<std::size_t>(robot)].log; }
  int robots() const { return static_cast<int>(robots_.size()); }

 private:
  struct Robot {
    std::string log, seen;
  };
  Robot& of(int robot) { return robots_[static_cast<std::size_t>(robot)]; }
  static void append(std::string& to, const void* bytes, std::size_t size) {
    to.append(static_cast<const char*>(bytes), size);
  }
  std::vector<Robot> robots_;
  int only_ = -1;  // none: all
};

}  // namespace arkmesh::sim_ode
