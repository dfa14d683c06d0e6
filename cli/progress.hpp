// The progress line of long work on stderr: in place on a terminal, a line each second elsewhere.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace arkmesh::cli {

class Progress {
 public:
  // `unit` is what the work is counted in.
  explicit Progress(std::string what, std::string unit = "period");
  // "shark  period 412/900  45.8 %  312x  eta 3 s", at most once a second; a wait is said at once and then every 5 s.
  void show(std::uint32_t period, std::uint32_t periods, double period_s, const std::string& state = "running");
  // Ends the line in place.
  void done();

 private:
  using WallClock = std::chrono::steady_clock;
  std::string what_, unit_, last_state_;
  bool terminal_;
  bool open_ = false;
  WallClock::time_point begun_, due_;
};

}  // namespace arkmesh::cli
