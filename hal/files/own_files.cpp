#include "hal/files/own_files.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <chrono>
#include <stdexcept>
#include <utility>

#include "hal/child_process.hpp"

namespace arkmesh::hal {
namespace {

namespace fs = std::filesystem;

ChildStart start_of(const std::string& name, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), own_file(name, fs::path("drawing") / name).string());
  ChildStart start{.command = std::move(arguments)};
  // What scripts look for beside a program that was built, and not installed: the message types for Python.
  const fs::path types = program_folder() / "lcmtypes" / "python";
  std::error_code ignored;
  if (!::getenv("ARKMESH_LCM_TYPES") && fs::is_directory(types, ignored))
    start.environment = {"ARKMESH_LCM_TYPES=" + types.string()};
  return start;
}

// Set once, at the beginning of main().
fs::path& built_against() {
  static fs::path folder;
  return folder;
}

std::string without_end(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

}  // namespace

fs::path this_program() {
  std::error_code ignored;
  return fs::read_symlink("/proc/self/exe", ignored);
}

fs::path program_folder() {
  std::error_code ignored;
  fs::path own = this_program().parent_path();
  return built_against().empty() || fs::exists(own / "arkmesh", ignored) ? own : built_against();
}

void use_programs_in(fs::path folder) {
  built_against() = std::move(folder);
}

fs::path own_file(const fs::path& installed, const fs::path& source) {
  const fs::path file = program_folder().parent_path() / "share" / "arkmesh" / installed;
  std::error_code ignored;
  return fs::exists(file, ignored) ? file : ARKMESH_SOURCE_DIR / source;
}

std::string run_script(const std::string& name, std::vector<std::string> arguments) {
  ChildStart start = start_of(name, std::move(arguments));
  const std::string file = start.command.front();
  const Finished done = run_to_end(std::move(start), std::chrono::minutes(30));
  std::string last = without_end(done.output);
  last.erase(0, last.rfind('\n') + 1);
  if (done.too_long) throw std::runtime_error(fmt::format("{} took longer than half an hour", file));
  if (done.status != 0)
    throw std::runtime_error(last.empty() ? fmt::format("{} cannot be started; it needs /usr/bin/python3", file)
                                          : last);
  return last;
}

std::string watch_script(const std::string& name, std::vector<std::string> arguments) {
  ChildStart start = start_of(name, std::move(arguments));
  const std::string file = start.command.front();
  start.own_group = start.keeps_errors = false;
  start.last_signal = SIGTERM;
  const Finished done = run_to_end(std::move(start), std::nullopt);
  if (done.status < 0 || done.status == 127)
    throw std::runtime_error(fmt::format("{} did not finish; it needs /usr/bin/python3", file));
  if (done.status != 0) throw std::runtime_error(fmt::format("{} wrote nothing", name));
  return without_end(done.output);
}

}  // namespace arkmesh::hal
