// What robots printed, as lines for people: which robot, when, what. Bounded, and says how much it left out.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sim_ode/host/programs/program_text.hpp"

namespace arkmesh::sim_ode {

class RobotText {
 public:
  // At most `max_lines` of each robot, and a hundred times as many in all.
  explicit RobotText(int max_lines) : max_lines_(static_cast<std::uint64_t>(max_lines)) {}

  // The lines that `pieces` complete, each with its end of line; empty when there is none to show.
  std::string lines(std::span<const sim_ode::ProgramText::Piece> pieces);
  // What robots began and did not end with a line end, robots in order. At the end of a run.
  std::string unfinished();
  // A line on what was not shown; empty when all was. `lost` characters did not even get here.
  std::string left_out(std::uint64_t lost) const;

 private:
  struct Robot {
    std::uint64_t shown = 0;
    std::int64_t at_us = 0;  // of the line's first character
    std::string line;
    bool cut = false;
  };
  void end_line(int robot, std::string& out);
  std::uint64_t max_lines_, shown_ = 0, left_out_ = 0;
  std::vector<Robot> robots_;
};

}  // namespace arkmesh::sim_ode
