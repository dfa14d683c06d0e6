// The numbers in a compiled program's variables, by name: what a debugger knows of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace arkmesh::sim_ode {

struct ProgramVariables {
  struct Number {
    std::uint64_t address = 0;
    unsigned bytes = 0;
    char type = 'u';  // 's' signed, 'u' unsigned, 'f' a fraction
  };
  std::map<std::string, Number> numbers;  // "count", "loop: count" of a function, "heard[3].id"
  std::vector<std::string> others;        // variables with pointers, unions or bit fields, as far as these go

  // `tool` is binutils' readelf for that processor. `scratch` is an empty folder. Throws std::runtime_error.
  static ProgramVariables read(const std::string& tool, const std::filesystem::path& object,
                               const std::filesystem::path& scratch);
};

}  // namespace arkmesh::sim_ode
