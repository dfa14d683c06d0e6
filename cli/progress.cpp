#include "cli/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace arkmesh::cli {

Progress::Progress(std::string what, std::string unit)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      terminal_(isatty(STDERR_FILENO) != 0),
      begun_(WallClock::now()),
      due_(begun_) {}

void Progress::show(std::uint32_t period, std::uint32_t periods, double period_s, const std::string& state) {
  const auto now = WallClock::now();
  // A wait is said at once and then every five seconds; running work each second.
  const bool waits = state.starts_with("waiting");
  if (now < due_ && !(waits && last_state_.starts_with("running"))) return;
  due_ = now + (waits ? std::chrono::seconds(5) : std::chrono::seconds(1));
  last_state_ = state;
  const double wall_s = std::chrono::duration<double>(now - begun_).count();
  const double speed = wall_s > 0 ? period * period_s / wall_s : 0;
  std::string line = fmt::format("{}  {} {}/{}  {:.1f} %  {:.0f}x", what_, unit_, period, periods,
                                 periods ? 100.0 * period / periods : 100.0, speed);
  if (waits)
    line += "  " + state;
  else if (speed > 0)
    line += fmt::format("  eta {:.0f} s", (periods - period) * period_s / speed);
  if (terminal_)
    fmt::print(stderr, "\r\033[K{}", line);
  else
    fmt::print(stderr, "{}\n", line);
  std::fflush(stderr);
  open_ = terminal_;
}

void Progress::done() {
  if (open_) fmt::print(stderr, "\r\033[K");
  open_ = false;
}

}  // namespace arkmesh::cli
