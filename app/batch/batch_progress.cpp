#include "app/batch/batch_progress.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "hal/counted.hpp"

namespace arkmesh::app {
namespace {

constexpr std::size_t bar_width = 24;

// "3 h 05 min", "4 min 10 s", "12 s".
std::string duration(double seconds) {
  const auto s = static_cast<long>(std::ceil(seconds));
  if (s >= 3600) return fmt::format("{} h {:02} min", s / 3600, s % 3600 / 60);
  return s >= 60 ? fmt::format("{} min {:02} s", s / 60, s % 60) : fmt::format("{} s", s);
}

}  // namespace

void BatchProgress::ended(const RunPool::Ended& run, const RunTask& task) {
  ++ended_;
  if (run.finished) return;
  ++failed_;
  std::string said = run.said.substr(0, run.said.find('\n'));
  if (said.starts_with("arkmesh: ")) said.erase(0, 9);
  line_.say(fmt::format("run {} (seed {}) did not finish{}{}", run.number, task.seed, said.empty() ? "" : ": ", said));
}

void BatchProgress::show(std::size_t running) {
  const std::size_t before = all_ - open_, done = before + ended_;
  const std::size_t filled = all_ == 0 ? bar_width : done * bar_width / all_;
  std::string text = fmt::format("[{}{}] {}/{}", std::string(filled, '#'), std::string(bar_width - filled, '.'), done,
                                 hal::counted(all_, "run"));
  if (failed_ > 0) text += fmt::format(", {} failed", failed_);
  const double elapsed_s = std::chrono::duration<double>(Clock::now() - begun_).count();
  if (ended_ > 0 && ended_ < open_)
    text += fmt::format(", {} left",
                        duration(elapsed_s * static_cast<double>(open_ - ended_) / static_cast<double>(ended_)));
  else if (running > 0)
    text += fmt::format(", {} running", running);
  line_.show(text);
}

}  // namespace arkmesh::app
