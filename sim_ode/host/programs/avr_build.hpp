// Builds a program and a stand-in for the robot's library for the robot's processor: to be measured, and to be run in
// an emulator. Not for robots, whose library is not at hand.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/files/scratch_folder.hpp"
#include "sim_ode/host/programs/avr_tools.hpp"

namespace arkmesh::sim_ode {

// What the boot loader leaves, and what the robot's library itself takes of it (a program with empty setup and loop).
inline constexpr int flash_limit_bytes = 28160, flash_library_bytes = 7054;
inline constexpr int ram_limit_bytes = 2048, ram_library_bytes = 110;

class AvrBuild {
 public:
  // `options`: for the compiler, beside the robot's. All throw std::runtime_error with one sentence: no avr-gcc, or it
  // does not build.
  AvrBuild(const ReadProgram& program, std::string name, std::vector<std::string> options = {},
           std::string processor = "atmega328p");

  const std::filesystem::path& elf() const { return elf_; }
  const std::filesystem::path& folder() const { return folder_.path(); }
  // What the compiler said of the program.
  const std::string& said() const { return said_; }
  // With the robot's library in place of ours: the program is what an empty one does not have.
  Sizes sizes() const;

 private:
  std::string compile(const std::filesystem::path& source, const std::string& object,
                      const std::vector<std::string>& options = {}) const;
  std::filesystem::path link(std::vector<std::string> objects, const std::string& elf) const;
  [[noreturn]] void refuse(const char* what, const std::string& output) const;

  hal::ScratchFolder folder_;
  std::string name_;
  std::vector<std::string> language_;
  std::filesystem::path elf_;
  std::string said_;
};

// The lines with one of `marks`, at most `most`.
std::vector<std::string> lines_with(const std::string& output, std::initializer_list<const char*> marks,
                                    std::size_t most);
// Where the stand-in and the emulator lie. Throws ProgramError.
std::filesystem::path silicon_folder();

}  // namespace arkmesh::sim_ode
