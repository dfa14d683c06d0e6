// The robot's library is not at hand; stand-ins of known size take its place in the link, so that what the program
// itself brings along, parts of the C library included, is the difference to an empty program.
#include "sim_ode/host/programs/controller_check.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "hal/scratch_folder.hpp"
#include "sim_ode/host/programs/avr_tools.hpp"
#include "sim_ode/host/programs/robot_program.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

// On a robot the clock is a variable.
constexpr const char* prelude = R"(#include "kilolib.h"
#undef kilo_ticks
extern volatile uint32_t kilo_ticks;
)";

// Of the C library it uses what the robot's library uses: rand() and arithmetic with fractions.
constexpr const char* stand_ins = R"(#include <stdlib.h>
#undef kilo_ticks
volatile uint32_t kilo_ticks;
volatile uint16_t kilo_tx_period;
uint16_t kilo_uid, kilo_irhigh[14], kilo_irlow[14];
uint8_t kilo_turn_left, kilo_turn_right, kilo_straight_left, kilo_straight_right;
message_rx_t kilo_message_rx;
message_tx_t kilo_message_tx;
message_tx_success_t kilo_message_tx_success;
void kilo_init() {}
void kilo_start(void (*setup)(void), void (*loop)(void)) { setup(); for (;;) loop(); }
void delay(uint16_t ms) { while (ms--) kilo_ticks++; }
void set_motors(uint8_t left, uint8_t right) { kilo_ticks = left + right; }
void spinup_motors() { kilo_ticks = rand(); }
void set_color(uint8_t color) { kilo_ticks = color; }
uint8_t estimate_distance(const distance_measurement_t *d) {
  volatile float high = d->high_gain;
  return high < 700.0 ? 33 + high : (uint8_t)(33 + (high * (900.0 - high) + high * (high - 700.0)) / 200.0);
}
int16_t get_ambientlight() { return kilo_ticks; }
int16_t get_voltage() { return kilo_ticks; }
int16_t get_temperature() { return kilo_ticks; }
uint8_t rand_hard() { return kilo_ticks; }
uint8_t rand_soft() { return kilo_ticks; }
void rand_seed(uint8_t seed) { kilo_ticks = seed; }
uint16_t message_crc(const message_t *msg) { return msg->data[0]; }
void arkmesh_serial_on(void) {}
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

// The lines with one of `marks`, at most `most`.
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

class Builder {
 public:
  explicit Builder(const fs::path& folder) : folder_(folder) {
    write(folder / "prelude.h", prelude);
    write(folder / "stand_ins.c", stand_ins);
    write(folder / "empty.c", empty_program);
  }
  // As the robot's library is built; our headers last, so that <avr/io.h> and <stdlib.h> are the robot's own.
  std::vector<std::string> language() const {
    return {"avr-gcc",         "-mmcu=atmega328p",
            "-DF_CPU=8000000", "-std=gnu99",
            "-fgnu89-inline",  "-Os",
            "-funsigned-char", "-funsigned-bitfields",
            "-fpack-struct",   "-fshort-enums",
            "-fcommon",        "-Wtype-limits",
            "-Wconversion",    "-fno-diagnostics-show-caret",
            "-idirafter",      kilolib_folder().string(),
            "-idirafter",      firmware_folder().string(),
            "-include",        (folder_ / "prelude.h").string()};
  }
  // Compiles `source`, returns what the compiler said. Throws when it does not compile.
  std::string compile(const fs::path& source, const std::string& object,
                      const std::vector<std::string>& options = {}) const {
    std::vector<std::string> command = language();
    command.insert(command.end(), options.begin(), options.end());
    command.insert(command.end(), {"-c", source.string(), "-o", (folder_ / object).string()});
    const hal::Finished done = run_avr(std::move(command));
    if (done.status != 0) refuse("does not compile for the robot", source, done.output);
    return done.output;
  }
  Sizes link(const std::vector<std::string>& objects, const fs::path& source) const {
    const fs::path elf = folder_ / (objects.front() + ".elf");
    std::vector<std::string> command = {"avr-gcc", "-mmcu=atmega328p", link_without_limits};
    for (const std::string& object : objects) command.push_back((folder_ / object).string());
    command.insert(command.end(), {(folder_ / "stand_ins.o").string(), "-lm", "-o", elf.string()});
    const hal::Finished done = run_avr(std::move(command));
    if (done.status != 0) refuse("does not link for the robot", source, done.output);
    return measured(elf);
  }

 private:
  [[noreturn]] static void refuse(const char* what, const fs::path& source, const std::string& output) {
    const auto errors =
        lines_with(output, {"error:", "undefined reference", "multiple definition", "overflowed", "will not fit"}, 1);
    throw std::runtime_error(fmt::format("{} {}: {}", source.string(), what,
                                         errors.empty() ? output.substr(0, output.find('\n')) : errors[0]));
  }
  fs::path folder_;
};

}  // namespace

CheckedProgram check_program(const ProgramSources& sources) {
  const ReadProgram program(sources);
  const hal::ScratchFolder folder("check");
  const Builder builder(folder.path());
  std::string said;
  std::vector<std::string> objects;
  for (const fs::path& file : compiled_alone(program, builder.language())) {
    objects.push_back(fmt::format("program{}.o", objects.size()));
    said += builder.compile(file, objects.back(), program.options_for(file));
  }
  builder.compile(folder.path() / "stand_ins.c", "stand_ins.o");
  builder.compile(folder.path() / "empty.c", "empty.o");
  const Sizes empty = builder.link({"empty.o"}, "empty.c"), full = builder.link(objects, sources.name());

  // and as the simulator compiles it
  try {
    RobotProgram::load(sources);
  } catch (const ProgramError& error) {
    throw std::runtime_error(
        fmt::format("{}: fits the robot's compiler, but `run` refuses it: {}", sources.name(), error.what()));
  }

  CheckedProgram out;
  out.flash_bytes = flash_library_bytes + full.flash - empty.flash;
  out.ram_bytes = ram_library_bytes + full.ram - empty.ram;
  for (const std::string& line : lines_with(said, {"[-Woverflow]", "[-Wshift-count-overflow]", "[-Wtype-limits]"}, 100))
    out.warnings.push_back(line);
  // Of conversions only those that squeeze something wider into an int of 16 bits; others are on a PC as they are here.
  for (const std::string& line :
       lines_with(said, {"to ‘int’", "to 'int'", "to ‘unsigned int’", "to 'unsigned int'"}, 100))
    if (line.find("long") != std::string::npos) out.warnings.push_back(line);
  return out;
}

}  // namespace arkmesh::sim_ode
