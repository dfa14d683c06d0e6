#include "sim_ode/host/programs/avr_tools.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "sim_ode/host/programs/compiler_limits.hpp"
#include "sim_ode/host/programs/program_inputs.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

}  // namespace

hal::Finished run_avr(std::vector<std::string> command) {
  const std::string tool = command[0];
  const CompilerLimits limits;
  hal::Finished done = hal::run_to_end({.command = std::move(command), .processor_time = limits.work}, limits.time);
  if (done.status == 127)
    throw std::runtime_error(
        fmt::format("{}, of the robot's compiler, is missing; apt-get install gcc-avr avr-libc binutils-avr", tool));
  if (done.too_long)
    throw std::runtime_error(fmt::format("{} was ended because it had not finished after {}", tool, limits.text()));
  return done;
}

std::vector<fs::path> compiled_alone(const ReadProgram& program, const std::vector<std::string>& words) {
  std::vector<fs::path> files, out;
  std::vector<std::vector<std::string>> read;
  for (const ReadProgram::File& file : program.files) {
    files.push_back(file.path);
    if (program.files.size() == 1) return files;
    std::vector<std::string> command = words;
    std::ranges::move(program.options_for(file.path), std::back_inserter(command));
    command.insert(command.end(), {"-MM", file.path.string()});
    const hal::Finished done = run_avr(std::move(command));
    read.push_back(done.status == 0 ? paths_in_rules(done.output) : std::vector<std::string>());
  }
  const std::vector<bool> included = included_by_others(files, read);
  for (std::size_t i = 0; i < files.size(); ++i)
    if (!included[i]) out.push_back(files[i]);
  return out.empty() ? files : out;
}

Sizes measured(const fs::path& elf) {
  const hal::Finished sizes = run_avr({"avr-size", elf.string()});
  std::istringstream rows(sizes.output);
  std::string header;
  int text = 0, data = 0, bss = 0;
  std::getline(rows, header);
  if (sizes.status != 0 || !(rows >> text >> data >> bss))
    throw std::runtime_error("avr-size cannot measure the program; apt-get install binutils-avr");
  return {text + data, data + bss};
}

}  // namespace arkmesh::sim_ode
