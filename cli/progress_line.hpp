// How far long work is, as one line on stderr: in place on a terminal, now and then a line of its own elsewhere.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "hal/progress.hpp"

namespace arkmesh::cli {

class ProgressLine final : public hal::Progress {
 public:
  // `what` stands before everything; nothing by default. `unit` is what counted work is counted in.
  explicit ProgressLine(std::string what = {}, std::string unit = "period");
  ~ProgressLine() override { done(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  // "identify: 3 of 12 robots": elsewhere than on a terminal each two seconds, and each thirty while it says the same.
  void show(const std::string& text) override;
  // "shark  period 412/900  45.8 %  312x  eta 3 s", at most once a second; a wait is said at once and then every 5 s.
  void show(std::uint32_t done, std::uint32_t all, double unit_s, const std::string& state = "running") override;
  void done() override;
  void say(const std::string& line) override;
  // The same once the work has gone on for `time`; never when it ends before.
  void say_after(std::chrono::milliseconds time, std::string line);

 private:
  using Clock = std::chrono::steady_clock;
  void say_later(Clock::time_point now);
  std::string what_, unit_, text_, state_, later_;
  bool terminal_, open_ = false;
  Clock::time_point begun_, due_, same_due_, later_due_;
};

}  // namespace arkmesh::cli
