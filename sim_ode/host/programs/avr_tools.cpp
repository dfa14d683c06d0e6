#include "sim_ode/host/programs/avr_tools.hpp"

#include <fmt/format.h>

#include <sstream>
#include <stdexcept>
#include <system_error>

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

}  // namespace

Finished run_avr(std::vector<std::string> command) {
  const std::string tool = command[0];
  // coreutils' timeout ends the compiler's own children, too; its codes are 124 for that, 127 for a missing command
  command.insert(command.begin(), {"timeout", "--kill-after=2", "60"});
  Finished done = run_to_end(command);
  if (done.status == 127 || (done.status == -1 && done.output.empty()))
    throw std::runtime_error(
        fmt::format("{}, of the robot's compiler, is missing; apt-get install gcc-avr avr-libc binutils-avr", tool));
  if (done.status == 124 || done.status == 137)
    throw std::runtime_error(fmt::format("{} did not end within a minute", tool));
  return done;
}

Sizes measured(const fs::path& elf) {
  const Finished sizes = run_avr({"avr-size", elf.string()});
  std::istringstream rows(sizes.output);
  std::string header;
  int text = 0, data = 0, bss = 0;
  std::getline(rows, header);
  if (sizes.status != 0 || !(rows >> text >> data >> bss))
    throw std::runtime_error("avr-size cannot measure the program; apt-get install binutils-avr");
  return {text + data, data + bss};
}

}  // namespace arkmesh::sim_ode
