#include "cli/status_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace arkmesh::cli {

using namespace std::chrono_literals;

StatusLine::StatusLine(std::string what)
    : what_(what.empty() ? "" : what + ": "), terminal_(isatty(STDERR_FILENO) == 1) {}

void StatusLine::show(const std::string& text) {
  const auto now = std::chrono::steady_clock::now();
  if (now < due_ || (text == text_ && now < same_due_)) return;
  due_ = now + (terminal_ ? 100ms : 2000ms);
  same_due_ = now + (terminal_ ? 100ms : 30'000ms);
  text_ = text;
  fmt::print(stderr, "{}{}{}{}", terminal_ ? "\r" : "", what_, text, terminal_ ? "\033[K" : "\n");
  std::fflush(stderr);
  open_ = terminal_;
}

void StatusLine::done() {
  if (std::exchange(open_, false)) fmt::print(stderr, "\r\033[K");
}

}  // namespace arkmesh::cli
