#include "sim_ode/host/programs/shipped_programs.hpp"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <map>
#include <string>
#include <system_error>

#include "hal/files/own_files.hpp"
#include "hal/files/scratch_folder.hpp"
#include "sim_ode/host/programs/content_hash.hpp"
#include "sim_ode/host/programs/object_build.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

void add_files(ContentHash& hash, const fs::path& folder) {
  std::map<std::string, fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied))
    if (entry.is_regular_file()) files[entry.path().lexically_relative(folder).string()] = entry.path();
  for (const auto& [name, file] : files) {
    hash.add(name);
    hash.add(read_source(file));
  }
}

// Every header that a program could include counts, whether it does or not: to know better takes a compiler.
void add_headers(ContentHash& hash, const fs::path& folder) {
  std::map<std::string, std::string> texts;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    if (at->path().extension() == ".h") texts[at->path().filename().string()] = read_source(at->path());
  for (const auto& [name, text] : texts) {
    hash.add(name);
    hash.add(text);
  }
}

std::string object_name(const ReadProgram& program) {
  ContentHash hash;
  utsname machine{};
  uname(&machine);
  hash.add(machine.machine);
  hash.add(ARKMESH_VERSION);
  for (const std::string& macro : program.define) hash.add(macro);
  for (const ReadProgram::File& file : program.files) {
    hash.add(file.text);
    for (const fs::path& folder : program.folders_for(file.path)) add_headers(hash, folder);
  }
  add_files(hash, kilolib_folder());
  add_files(hash, firmware_folder());
  return hash.name() + ".so";
}

}  // namespace

fs::path shipped_programs_folder() {
  return hal::program_folder().parent_path() / "lib" / "arkmesh" / "programs";
}

std::optional<fs::path> find_shipped(const ReadProgram& program, const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return {};
  fs::path object = folder / object_name(program);
  return fs::exists(object, error) ? std::optional(std::move(object)) : std::nullopt;
}

void ship_program(const ReadProgram& program, const fs::path& folder) {
  const hal::ScratchFolder work("controller");
  ObjectBuild build(program, work.path());
  build.run();
  std::error_code error;
  fs::create_directories(folder, error);
  fs::copy_file(build.object(), folder / object_name(program), fs::copy_options::overwrite_existing, error);
  if (error) throw ProgramError(fmt::format("{} cannot be written: {}", folder.string(), error.message()));
}

}  // namespace arkmesh::sim_ode
