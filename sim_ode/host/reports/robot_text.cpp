// Characters that a terminal would act on are shown as dots.
#include "sim_ode/host/reports/robot_text.hpp"

#include <fmt/format.h>

#include <utility>

#include "hal/counted.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr std::size_t longest_line = 200;

}  // namespace

std::string RobotText::lines(std::span<const sim_ode::ProgramText::Piece> pieces) {
  std::string out;
  for (const auto& piece : pieces) {
    const auto i = static_cast<std::size_t>(piece.robot);
    if (i >= robots_.size()) robots_.resize(i + 1);
    Robot& robot = robots_[i];
    for (const char c : piece.text) {
      if (robot.line.empty() && !robot.cut) robot.at_us = piece.at_us;
      if (c == '\n')
        end_line(piece.robot, out);
      else if (c == '\r' || c == '\0')
        continue;
      else if (robot.line.size() < longest_line)
        robot.line += c == '\t' || (c >= ' ' && c != 0x7F) || static_cast<unsigned char>(c) >= 0x80 ? c : '.';
      else
        robot.cut = true;
    }
  }
  return out;
}

void RobotText::end_line(int number, std::string& out) {
  Robot& robot = robots_[static_cast<std::size_t>(number)];
  if (robot.shown < max_lines_ && shown_ < 100 * max_lines_) {
    ++robot.shown;
    ++shown_;
    out += fmt::format("{:9.3f} s  robot {}: {}{}\n", static_cast<double>(robot.at_us) * 1e-6, number, robot.line,
                       robot.cut ? "..." : "");
  } else {
    ++left_out_;
  }
  robot.line.clear();
  robot.cut = false;
}

std::string RobotText::unfinished() {
  std::string out;
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (!robots_[i].line.empty()) end_line(static_cast<int>(i), out);
  return out;
}

std::string RobotText::left_out(std::uint64_t lost) const {
  if (left_out_ == 0 && lost == 0) return {};
  std::string out = fmt::format("text       {} not shown; --text {} shows more", hal::counted(left_out_, "more line"),
                                std::max<std::uint64_t>(10, max_lines_ * 10));
  if (lost > 0) out += fmt::format("; {} came too fast to be kept", hal::counted(lost, "character"));
  return out + "\n";
}

}  // namespace arkmesh::sim_ode
