// A Kilobot C program, compiled and loaded: its code once, and the picture of a robot's memory before its first
// instruction. Knows nothing of time, robots or worlds.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sim_ode/host/programs/object_build.hpp"
#include "sim_ode/kilolib/robot_abi.h"

namespace arkmesh::sim_ode {

class ProgramCache;

class RobotProgram {
 public:
  // Compiles with `cc`, unless it was compiled before (shipped_programs.hpp, program_cache.hpp). Programs of the same
  // files, texts and options that are in use at the same time are loaded once. Throws ProgramError.
  static std::shared_ptr<const RobotProgram> load(const ProgramSources& sources);
  ~RobotProgram() { unload(); }
  RobotProgram(const RobotProgram&) = delete;
  RobotProgram& operator=(const RobotProgram&) = delete;

  // The first of its files.
  const std::filesystem::path& source() const { return source_; }
  const arkmesh_program& abi() const { return *abi_; }
  // Bytes of a robot's memory, and those bytes before main() ran.
  std::size_t memory_bytes() const { return first_.size(); }
  const std::vector<std::byte>& first_memory() const { return first_; }
  // That a robot has for malloc(): what its variables leave of 2 KB, times four, because pointers are wider here.
  std::size_t heap_bytes() const;
  // The object's file, for tools that read it, and where in it a robot's memory begins.
  std::filesystem::path object() const;
  std::uintptr_t memory_address() const;
  // Source line of an instruction, " at loop (prog.c:17)"; empty when it is none of the program's.
  std::string place_of(const void* instruction) const;

 private:
  RobotProgram() = default;
  bool load_kept(const ProgramCache& cache);
  void load_copy(const std::filesystem::path& object);
  void unload();
  // Throws ProgramError.
  void load_object(const std::filesystem::path& object);
  std::filesystem::path source_;
  void* handle_ = nullptr;
  int file_ = -1;  // keeps the object's file, deleted perhaps, for place_of(), and its inode from being used again
  const arkmesh_program* abi_ = nullptr;
  std::vector<std::byte> first_;
};

}  // namespace arkmesh::sim_ode
