#include "cli/progress_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace arkmesh::cli {

using namespace std::chrono_literals;

namespace {

// Work goes on when nobody reads any more, or the terminal is gone: fmt::print would throw.
void put(const std::string& text) {
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace

ProgressLine::ProgressLine(std::string what, std::string unit)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      terminal_(isatty(STDERR_FILENO) == 1),
      begun_(Clock::now()),
      due_(begun_),
      same_due_(begun_) {}

void ProgressLine::show(const std::string& text) {
  const auto now = Clock::now();
  say_later(now);
  if (now < due_ || (text == text_ && now < same_due_)) return;
  due_ = now + (terminal_ ? 100ms : 2000ms);
  same_due_ = now + (terminal_ ? 100ms : 30'000ms);
  text_ = text;
  put(fmt::format("{}{}{}{}{}", terminal_ ? "\r" : "", what_, what_.empty() ? "" : ": ", text,
                  terminal_ ? "\033[K" : "\n"));
  open_ = terminal_;
}

void ProgressLine::show(std::uint32_t done, std::uint32_t all, double unit_s, const std::string& state) {
  const auto now = Clock::now();
  say_later(now);
  // A wait, and work without a peer, is said at once and then every five seconds; running work each second.
  const bool waits = state.starts_with("waiting") || state.find(" without ") != std::string::npos;
  if (now < due_ && !(waits && state_ == "running")) return;
  due_ = now + (waits ? 5s : 1s);
  state_ = state;
  const double wall_s = std::chrono::duration<double>(now - begun_).count();
  const double speed = wall_s > 0 ? done * unit_s / wall_s : 0;
  std::string line =
      fmt::format("{}  {} {}/{}  {:.1f} %  {:.0f}x", what_, unit_, done, all, all ? 100.0 * done / all : 100.0, speed);
  if (waits)
    line += "  " + state;
  else if (speed > 0)
    line += fmt::format("  eta {:.0f} s", (all - done) * unit_s / speed);
  put(terminal_ ? "\r\033[K" + line : line + "\n");
  open_ = terminal_;
}

void ProgressLine::done() {
  if (std::exchange(open_, false)) put("\r\033[K");
}

void ProgressLine::say(const std::string& line) {
  done();
  put(line + "\n");
}

void ProgressLine::say_after(std::chrono::milliseconds time, std::string line) {
  later_ = std::move(line);
  later_due_ = Clock::now() + time;
}

void ProgressLine::say_later(Clock::time_point now) {
  if (!later_.empty() && now >= later_due_) say(std::exchange(later_, {}));
}

}  // namespace arkmesh::cli
