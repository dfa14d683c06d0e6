#include "cli/drawing_script.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <chrono>
#include <filesystem>
#include <stdexcept>

#include "sim_ode/host/subprocess.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

// What scripts look for beside a program that was built, and not installed: the message types for Python.
void tell_types() {
  std::error_code error;
  const fs::path types = fs::read_symlink("/proc/self/exe", error).parent_path() / "lcmtypes" / "python";
  if (fs::is_directory(types, error)) ::setenv("ARKMESH_LCM_TYPES", types.c_str(), 0);
}

}  // namespace

std::string run_drawing_script(const std::string& name, const std::vector<std::string>& arguments) {
  tell_types();
  std::vector<std::string> command = {sim_ode::script_of_arkmesh(name).string()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const sim_ode::Finished done = sim_ode::run_to_end(command, std::chrono::minutes(30));
  std::string last = done.output;
  while (last.ends_with('\n')) last.pop_back();
  if (const auto line = last.rfind('\n'); line != std::string::npos) last.erase(0, line + 1);
  if (done.too_long) throw std::runtime_error(fmt::format("{} took longer than half an hour", command.front()));
  if (done.status != 0)
    throw std::runtime_error(
        last.empty() ? fmt::format("{} cannot be started; it needs /usr/bin/python3", command.front()) : last);
  return last;
}

}  // namespace arkmesh::cli
