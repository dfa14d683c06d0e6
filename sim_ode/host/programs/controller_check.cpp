#include "sim_ode/host/programs/controller_check.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "sim_ode/host/programs/robot_program.hpp"

namespace arkmesh::sim_ode {

std::vector<std::string> warnings_in(const std::string& said) {
  std::vector<std::string> out;
  for (const std::string& line : lines_with(said, {"[-Woverflow]", "[-Wshift-count-overflow]", "[-Wtype-limits]"}, 100))
    out.push_back(line);
  // Of conversions only those that squeeze something wider into an int of 16 bits; others are on a PC as they are here.
  for (const std::string& line :
       lines_with(said, {"to ‘int’", "to 'int'", "to ‘unsigned int’", "to 'unsigned int'"}, 100))
    if (line.find("long") != std::string::npos) out.push_back(line);
  return out;
}

CheckedProgram check_program(const ProgramSources& sources) {
  const ReadProgram program(sources);
  std::vector<std::string> options = warning_options;
  options.insert(options.end(), dump_options.begin(), dump_options.end());
  const AvrBuild build(program, sources.name(), options);
  CheckedProgram out;
  out.sizes = build.sizes();

  // and as the simulator compiles it
  try {
    RobotProgram::load(sources);
  } catch (const ProgramError& error) {
    throw std::runtime_error(
        fmt::format("{} compiles for the robot, but `run` refuses it: {}", sources.name(), error.what()));
  }

  out.warnings = warnings_in(build.said());
  for (std::string& sentence : widths_of(build.folder(), build.said()).warnings)
    out.warnings.push_back(std::move(sentence));
  out.largest = largest_frame(build.folder());
  return out;
}

}  // namespace arkmesh::sim_ode
