// All commands of arkmesh: what each is for, and which program runs it. The programs lie in one folder: `arkmesh` hands
// over what is not its own, so that nothing loads libraries that it does not need.
#pragma once

#include <span>
#include <string_view>

namespace arkmesh::cli {

struct CommandRow {
  const char* name;
  const char* purpose;       // as --help lists it
  std::string_view program;  // the smallest that runs it
};

inline constexpr std::string_view light_program = "arkmesh";
inline constexpr std::string_view gateway_program = "arkmesh-gateway";
inline constexpr std::string_view lab_program = "arkmesh-lab";              // simulated arenas
inline constexpr std::string_view recording_program = "arkmesh-recording";  // recorded runs
inline constexpr std::string_view testbed_program = "arkmesh-testbed";      // cameras, and all that arkmesh-lab does

// In the order in which --help lists them.
std::span<const CommandRow> command_table();
// Null when there is no such command.
const CommandRow* find_command(std::string_view name);

}  // namespace arkmesh::cli
