// Compiles into a directory that is gone before load() returns: also a killed process leaves nothing behind.
#include "sim_ode/host/programs/robot_program.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include "hal/child_process.hpp"
#include "hal/files/scratch_folder.hpp"
#include "sim_ode/host/programs/program_cache.hpp"
#include "sim_ode/host/programs/shipped_programs.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

// Of a robot's static memory; text buffers of programs for PCs were seen to take 11 kB.
constexpr std::size_t max_memory_bytes = 256 << 10;

std::map<std::string, std::weak_ptr<const RobotProgram>>& loaded_programs() {
  static std::map<std::string, std::weak_ptr<const RobotProgram>> programs;
  return programs;
}

// All that a user gives.
std::string whole(const ReadProgram& program) {
  std::string out;
  const auto add = [&](const std::string& part) { out += fmt::format("{} {}", part.size(), part); };
  for (const auto& [path, text] : program.files) add(one_spelling(path).string()), add(text);
  for (const fs::path& folder : program.include) add(one_spelling(folder / "").string());
  for (const std::string& macro : program.define) add("-D" + macro);
  return out;
}

}  // namespace

std::shared_ptr<const RobotProgram> RobotProgram::load(const ProgramSources& sources) {
  const ReadProgram read(sources);
  std::erase_if(loaded_programs(), [](const auto& entry) { return entry.second.expired(); });
  const std::string key = whole(read);
  if (const auto found = loaded_programs().find(key); found != loaded_programs().end())
    if (auto program = found->second.lock()) return program;

  std::shared_ptr<RobotProgram> program(new RobotProgram);
  program->source_ = read.files.front().path;
  if (const auto shipped = find_shipped(read, shipped_programs_folder())) {
    program->load_copy(*shipped);
    loaded_programs()[key] = program;
    return program;
  }
  const hal::ScratchFolder work("controller");
  ObjectBuild build(read, work.path());
  const ProgramCache cache(ProgramCache::folder_of_user(), build);
  if (!program->load_kept(cache)) {
    build.run();
    program->load_object(build.object());
    cache.keep();
  }
  loaded_programs()[key] = program;
  return program;
}

// False when there is none, or it does not load: it may just have left, or be of a machine with other libraries.
bool RobotProgram::load_kept(const ProgramCache& cache) {
  const std::optional<fs::path> object = cache.find();
  if (!object) return false;
  // its memory would not be as before the first instruction
  if (void* const loaded = dlopen(object->c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD)) {
    dlclose(loaded);
    return false;
  }
  try {
    load_object(*object);
    return true;
  } catch (const ProgramError&) {
    unload();
    return false;
  }
}

// Of an object that several programs may be: a library that is loaded twice has one memory.
void RobotProgram::load_copy(const fs::path& object) {
  const hal::ScratchFolder work("controller");
  const fs::path copy = work.path() / "program.so";
  std::error_code error;
  fs::copy_file(object, copy, error);
  if (error)
    throw ProgramError(fmt::format("does not load: {} cannot be copied: {}", object.string(), error.message()));
  load_object(copy);
}

void RobotProgram::load_object(const fs::path& object) {
  file_ = open(object.c_str(), O_RDONLY | O_CLOEXEC);
  handle_ = dlopen(object.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle_) throw ProgramError(fmt::format("does not load: {}", dlerror()));
  abi_ = static_cast<const arkmesh_program*>(dlsym(handle_, "arkmesh_program"));
  if (!abi_) throw ProgramError("does not load: it lacks the simulator's part");

  if (abi_->pc_types)
    spdlog::warn(
        "{} runs with a PC's types (32-bit int, 64-bit long and double), twice as wide as a robot's; with a robot's "
        "types it {}",
        source_.string(), abi_->pc_types);

  // behind a robot's memory: a page to read, then one to be caught at
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  char* const end = abi_->end;
  if (reinterpret_cast<std::uintptr_t>(end) % page != 0 || mprotect(end, page, PROT_READ) != 0 ||
      mprotect(end + page, page, PROT_NONE) != 0)
    throw ProgramError("does not load: its memory cannot be protected");

  if (const auto bytes = static_cast<std::size_t>(end - abi_->begin); bytes > max_memory_bytes)
    throw ProgramError(
        fmt::format("its variables take {} bytes; a robot has 2048, and the simulator gives it at most {}", bytes,
                    max_memory_bytes));
  const auto* begin = reinterpret_cast<const std::byte*>(abi_->begin);
  first_.assign(begin, begin + (end - abi_->begin));
}

std::size_t RobotProgram::heap_bytes() const {
  // the library takes 110 bytes; some variables take more here than on a robot, so there is always something left
  constexpr std::ptrdiff_t most = 2048 - 110, least = 512, pad = 48;
  return static_cast<std::size_t>(4 * std::clamp(most - (abi_->end - pad - abi_->own), least, most));
}

void RobotProgram::unload() {
  if (handle_) dlclose(handle_);
  if (file_ >= 0) close(file_);
  handle_ = nullptr;
  file_ = -1;
}

fs::path RobotProgram::object() const {
  return fmt::format("/proc/{}/fd/{}", getpid(), file_);
}

std::uintptr_t RobotProgram::memory_address() const {
  Dl_info ours{};
  dladdr(abi_, &ours);
  return reinterpret_cast<std::uintptr_t>(abi_->begin) - reinterpret_cast<std::uintptr_t>(ours.dli_fbase);
}

std::string RobotProgram::place_of(const void* instruction) const {
  Dl_info where{};
  if (file_ < 0 || !dladdr(instruction, &where) || !where.dli_fbase) return {};
  Dl_info ours{};
  dladdr(abi_, &ours);
  if (where.dli_fbase != ours.dli_fbase) return {};
  const auto offset = reinterpret_cast<std::uintptr_t>(instruction) - reinterpret_cast<std::uintptr_t>(where.dli_fbase);
  const hal::Finished found =
      hal::run_to_end({.command = {"addr2line", "-f", "-s", "-e", object().string(), fmt::format("{:#x}", offset)}});
  std::istringstream lines(found.output);
  std::string function, line;
  if (found.status != 0 || !std::getline(lines, function) || !std::getline(lines, line) || line.starts_with("??"))
    return {};
  if (const auto extra = line.find(" (disc"); extra != std::string::npos) line.resize(extra);
  return fmt::format(" in {} ({})", function, line);
}

}  // namespace arkmesh::sim_ode
