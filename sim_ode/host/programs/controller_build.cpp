#include "sim_ode/host/programs/controller_build.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/files/scratch_folder.hpp"
#include "hal/platforms/kilobot/intel_hex.hpp"
#include "sim_ode/host/programs/controller_check.hpp"
#include "sim_ode/host/programs/robot_program.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

// What of the robot's library goes into a program.
struct RobotLibrary {
  std::vector<fs::path> headers;  // folders
  std::vector<fs::path> parts;    // sources, or one archive
};

RobotLibrary library_of(const fs::path& kilolib) {
  std::error_code ignored;
  RobotLibrary out;
  const bool is_file = kilolib.extension() == ".a" && fs::is_regular_file(kilolib, ignored);
  const fs::path folder = is_file ? fs::absolute(kilolib).parent_path() : kilolib;
  // kilolib's own Makefile leaves the archive in a folder below
  for (const fs::path& place : {folder, folder.parent_path()})
    if (out.headers.empty() && fs::exists(place / "kilolib.h", ignored)) out.headers.push_back(place);
  if (is_file) {
    out.parts.push_back(kilolib);
  } else if (fs::exists(folder / "kilolib.c", ignored)) {
    out.parts.push_back(folder / "kilolib.c");
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
      if (const fs::path& file = entry.path();
          file.filename().string().starts_with("message_") && (file.extension() == ".c" || file.extension() == ".S"))
        out.parts.push_back(file);
    std::sort(out.parts.begin(), out.parts.end());
  } else {
    for (const fs::path& archive : {folder / "kilolib.a", folder / "build" / "kilolib.a"})
      if (out.parts.empty() && fs::exists(archive, ignored)) out.parts.push_back(archive);
  }
  if (out.headers.empty() || out.parts.empty())
    throw hal::ConfigError(
        fmt::format("{} is no kilolib: name a folder with kilolib.h and with kilolib.c or kilolib.a, as `git clone` of "
                    "one gives it",
                    kilolib.string()));
  return out;
}

// As kilolib's own Makefile has it.
const std::vector<std::string>& robot_language() {
  static const std::vector<std::string> out = {"avr-gcc",
                                               "-mmcu=atmega328p",
                                               "-DF_CPU=8000000",
                                               "-funsigned-char",
                                               "-funsigned-bitfields",
                                               "-fpack-struct",
                                               "-fshort-enums",
                                               "-fcommon",
                                               "-fno-diagnostics-show-caret"};
  return out;
}

// Returns what the compiler said.
std::string compile_for_robot(const std::vector<std::string>& more, const fs::path& source) {
  std::vector<std::string> command = robot_language();
  command.insert(command.end(), more.begin(), more.end());
  hal::Finished done = run_avr(std::move(command));
  if (done.status != 0)
    throw BuildError(fmt::format("{} does not build for the robot, see above", source.string()), done.output);
  return done.output;
}

}  // namespace

BuiltProgram build_program(const ProgramSources& sources, const fs::path& kilolib, const fs::path& hex) {
  const ReadProgram program(sources);
  const RobotLibrary library = library_of(kilolib);
  const hal::ScratchFolder folder("build");
  const fs::path elf = folder.path() / "program.elf", made = folder.path() / "program.hex";
  std::vector<std::string> include;
  for (const fs::path& headers : library.headers) include.insert(include.end(), {"-I", headers.string()});
  include.insert(include.end(), {"-I", firmware_folder().string()});

  const auto compile = [&](const fs::path& source, const std::string& object, std::vector<std::string> options) {
    options.insert(options.end(), include.begin(), include.end());
    options.insert(options.end(), {"-c", source.string(), "-o", (folder.path() / object).string()});
    return compile_for_robot(options, source);
  };
  BuiltProgram out;
  std::vector<std::string> link = {link_without_limits};
  std::vector<std::string> language = robot_language();
  language.insert(language.end(), include.begin(), include.end());
  for (const fs::path& file : compiled_alone(program, language)) {
    const std::string object = fmt::format("program{}.o", link.size());
    std::vector<std::string> options = program.options_for(file);
    options.insert(options.end(), {"-std=gnu99", "-fgnu89-inline", "-Os"});
    out.said += compile(file, object, std::move(options));
    link.push_back((folder.path() / object).string());
  }
  for (const fs::path& part : library.parts) {
    if (part.extension() == ".a") {
      link.push_back(part.string());
      continue;
    }
    const std::string object = part.filename().string() + ".o";
    compile(part, object, {"-O3", "-w"});  // its interrupts are timed to be built so
    link.push_back((folder.path() / object).string());
  }
  link.insert(link.end(), {"-lm", "-o", elf.string()});
  out.said += compile_for_robot(link, sources.name());

  out.sizes = measured(elf);
  if (out.sizes.flash > flash_limit_bytes || out.sizes.ram > ram_limit_bytes) return out;
  const hal::Finished copied = run_avr({"avr-objcopy", "-O", "ihex", "-R", ".eeprom", "-R", ".fuse", "-R", ".lock",
                                        "-R", ".signature", elf.string(), made.string()});
  if (copied.status != 0) throw BuildError("avr-objcopy cannot create an Intel HEX file of the program", copied.output);
  // what an upload would refuse is not worth keeping
  out.pages = hal::kilobot::read_intel_hex(made).pages();
  std::error_code error;
  fs::copy_file(made, hex, fs::copy_options::overwrite_existing, error);
  if (error) throw hal::ConfigError(fmt::format("{} cannot be written: {}", hex.string(), error.message()));
  return out;
}

}  // namespace arkmesh::sim_ode
