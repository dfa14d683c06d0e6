#include "sim_ode/host/programs/avr_build.hpp"

#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "sim_ode/host/programs/object_build.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

// On a robot the clock is a variable. Waits of the C library are calls, so that they take no real time.
constexpr const char* prelude = R"(#include "kilolib.h"
#undef kilo_ticks
extern volatile uint32_t kilo_ticks;
#define _UTIL_DELAY_H_ 1
#define __HAS_DELAY_CYCLES 1
void arkmesh_wait_us(uint32_t us);
#define _delay_ms(ms) arkmesh_wait_us((uint32_t)((ms) * 1000))
#define _delay_us(us) arkmesh_wait_us((uint32_t)(us))
)";

constexpr const char* empty_program = R"(
void setup() {}
void loop() {}
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
)";

void write(const fs::path& file, const char* text) {
  if (!(std::ofstream(file) << text))
    throw std::runtime_error(file.string() + " cannot be written; free some space or set TMPDIR");
}

}  // namespace

std::vector<std::string> lines_with(const std::string& output, std::initializer_list<const char*> marks,
                                    std::size_t most) {
  std::vector<std::string> found;
  std::istringstream lines(output);
  for (std::string line; found.size() < most && std::getline(lines, line);)
    for (const char* mark : marks)
      if (line.find(mark) != std::string::npos) {
        found.push_back(line);
        break;
      }
  return found;
}

fs::path silicon_folder() {
  return kilolib_folder().parent_path() / "silicon";
}

// As the robot's library is built; our headers last, so that <avr/io.h> and <stdlib.h> are the robot's own.
AvrBuild::AvrBuild(const ReadProgram& program, std::string name, std::vector<std::string> options,
                   std::string processor)
    : folder_("avr"), name_(std::move(name)), language_{"avr-gcc",         "-mmcu=" + processor,
                                                        "-DF_CPU=8000000", "-std=gnu99",
                                                        "-fgnu89-inline",  "-Os",
                                                        "-funsigned-char", "-funsigned-bitfields",
                                                        "-fpack-struct",   "-fshort-enums",
                                                        "-fcommon",        "-ffunction-sections",
                                                        "-fdata-sections", "-fno-diagnostics-show-caret",
                                                        "-idirafter",      kilolib_folder().string(),
                                                        "-idirafter",      firmware_folder().string(),
                                                        "-include",        (folder_.path() / "prelude.h").string()} {
  language_.insert(language_.end(), options.begin(), options.end());
  write(folder() / "prelude.h", prelude);
  std::vector<std::string> objects = {"kilolib.o"};
  compile(silicon_folder() / "kilolib.c", objects[0], {"-w", "-Os"});
  try {
    for (const fs::path& file : compiled_alone(program, language_)) {
      objects.push_back(fmt::format("program{}.o", objects.size()));
      said_ += compile(file, objects.back(), program.options_for(file));
    }
    elf_ = link(std::move(objects), "program.elf");
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(error.what() + lies_elsewhere(program, error.what()));
  }
}

std::string AvrBuild::compile(const fs::path& source, const std::string& object,
                              const std::vector<std::string>& options) const {
  std::vector<std::string> command = language_;
  command.insert(command.end(), options.begin(), options.end());
  command.insert(command.end(), {"-x", "c", "-c", source.string(), "-o", (folder() / object).string()});
  hal::Finished done = run_avr(std::move(command));
  if (done.status != 0) refuse("does not compile for the robot", done.output);
  return std::move(done.output);
}

fs::path AvrBuild::link(std::vector<std::string> objects, const std::string& elf) const {
  std::vector<std::string> command = {"avr-gcc", language_[1], link_without_limits, "-Wl,--gc-sections"};
  for (const std::string& object : objects) command.push_back((folder() / object).string());
  command.insert(command.end(), {"-lm", "-o", (folder() / elf).string()});
  const hal::Finished done = run_avr(std::move(command));
  if (done.status != 0) refuse("does not link for the robot", done.output);
  return folder() / elf;
}

void AvrBuild::refuse(const char* what, const std::string& output) const {
  const auto errors =
      lines_with(output, {"error:", "undefined reference", "multiple definition", "overflowed", "will not fit"}, 1);
  throw std::runtime_error(
      fmt::format("{} {}: {}", name_, what, errors.empty() ? output.substr(0, output.find('\n')) : errors[0]));
}

Sizes AvrBuild::sizes() const {
  write(folder() / "empty.c", empty_program);
  compile(folder() / "empty.c", "empty.o");
  const Sizes full = measured(elf_), empty = measured(link({"kilolib.o", "empty.o"}, "empty.elf"));
  return {flash_library_bytes + full.flash - empty.flash, ram_library_bytes + full.ram - empty.ram};
}

}  // namespace arkmesh::sim_ode
