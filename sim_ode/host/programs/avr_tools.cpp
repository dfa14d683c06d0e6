#include "sim_ode/host/programs/avr_tools.hpp"

#include <fmt/format.h>

#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

}  // namespace

hal::Finished run_avr(std::vector<std::string> command) {
  const std::string tool = command[0];
  hal::Finished done = hal::run_to_end({.command = std::move(command)});
  if (done.status == 127)
    throw std::runtime_error(
        fmt::format("{}, of the robot's compiler, is missing; apt-get install gcc-avr avr-libc binutils-avr", tool));
  if (done.too_long) throw std::runtime_error(fmt::format("{} did not end within a minute", tool));
  return done;
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
