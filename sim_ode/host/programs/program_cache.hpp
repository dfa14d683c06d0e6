// Keeps compiled programs from run to run: a program is compiled when it, or anything that decides what comes out, is
// new. A file's name is the hash of all that decided it, so nothing is ever out of date, and no run depends on what is
// kept. Works for several processes at once without locks; without a folder that it may use it keeps nothing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "sim_ode/host/programs/object_build.hpp"

namespace arkmesh::sim_ode {

class ProgramCache {
 public:
  // What is kept is at most so large; files that were not used for the longest time leave.
  static constexpr std::uintmax_t most_bytes = 64 << 20;

  // $XDG_CACHE_HOME/arkmesh/controllers, else ~/.cache/arkmesh/controllers; empty when ARKMESH_CACHE is "off" or there
  // is no home. Throws ProgramError when ARKMESH_CACHE is anything else.
  static std::filesystem::path folder_of_user();

  // Of one program that is not compiled yet; the build outlives this. An empty folder keeps nothing.
  ProgramCache(std::filesystem::path folder, ObjectBuild& build);

  // The object's file, whole and to be loaded as it is; it may vanish at any time.
  std::optional<std::filesystem::path> find() const;
  // Keeps what the build has made, unless it depends on the moment. A folder that cannot be written is told once.
  void keep(std::uintmax_t most = most_bytes) const;

 private:
  std::filesystem::path folder_;
  const ObjectBuild& build_;
  std::filesystem::path object_;  // empty: nothing is kept
};

}  // namespace arkmesh::sim_ode
