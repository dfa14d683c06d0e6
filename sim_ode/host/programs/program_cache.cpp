// Two files for each program: KEY.inputs lists the files that have decided its objects so far, there or not; NAME.so is
// an object with a hash at its end, where NAME is the hash of KEY and of what those files say. A list may be old or
// damaged: an object was kept under the contents of all it depends on, so equal contents mean an equal object.
#include "sim_ode/host/programs/program_cache.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <sstream>
#include <system_error>
#include <vector>

#include "hal/child_process.hpp"
#include "hal/files/replace_file.hpp"
#include "sim_ode/host/programs/content_hash.hpp"
#include "sim_ode/host/programs/program_inputs.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

// What compilers read beside their arguments.
constexpr const char* deciding_variables[] = {"CPATH",         "C_INCLUDE_PATH",  "LIBRARY_PATH",
                                              "COMPILER_PATH", "GCC_EXEC_PREFIX", "SOURCE_DATE_EPOCH"};
// In a program they stand for the moment of compiling, or for a file that the compiler does not list.
constexpr const char* of_the_moment[] = {"__DATE__", "__TIME__", "__TIMESTAMP__", "incbin"};
// Before the path of a file whose size and age tell enough: the compiler's parts are large.
constexpr char by_age = '*';

// Size and age of a file, where symbolic links lead to.
std::string age_of(const fs::path& file) {
  struct stat about {};
  if (stat(file.c_str(), &about) != 0) return "absent";
  return fmt::format("{} {} {}", about.st_size, about.st_mtim.tv_sec, about.st_mtim.tv_nsec);
}

// A program of PATH.
std::string found_in_path(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const fs::path file = fs::path(folder) / name; access(file.c_str(), X_OK) == 0) return file.string();
  return {};
}

// The path of a part of the compiler, to be told by its age; empty when it has none of that name.
std::string part_of_compiler(const std::string& name) {
  std::string path = hal::run_to_end({.command = {"cc", "-print-prog-name=" + name}}).output;
  path.erase(std::min(path.find('\n'), path.size()));
  return path.starts_with('/') ? by_age + path : std::string();
}

// Only its owner, we or the system, can put anything there: we run what we find.
bool trusted(const fs::path& folder) {
  struct stat about {};
  return stat(folder.c_str(), &about) == 0 && S_ISDIR(about.st_mode) &&
         (about.st_uid == geteuid() || about.st_uid == 0) && (about.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

void warn_once(const fs::path& folder, const std::string& reason) {
  static std::atomic<bool> warned = false;
  if (!warned.exchange(true))
    spdlog::warn("controllers are compiled for each run: {} {}; ARKMESH_CACHE=off silences this", folder.string(),
                 reason);
}

std::string seal_of(const fs::path& object, std::string_view content) {
  ContentHash hash;
  hash.add(object.filename().string());
  hash.add(content);
  return hash.name();
}

// What was not used for the longest time leaves until the rest is small enough, and what a killed process left aside.
void trim(const fs::path& folder, std::uintmax_t most) {
  struct Kept {
    fs::path file;
    fs::file_time_type used;
    std::uintmax_t bytes;
  };
  std::vector<Kept> all;
  std::uintmax_t sum = 0;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code gone;
    const Kept kept{at->path(), at->last_write_time(gone), at->file_size(gone)};
    if (gone) continue;
    const std::string kind = kept.file.extension().string();
    if (kind == ".so" || kind == ".inputs") {
      all.push_back(kept);
      sum += kept.bytes;
    } else if (kept.used < fs::file_time_type::clock::now() - std::chrono::hours(1)) {
      fs::remove(kept.file, gone);
    }
  }
  std::sort(all.begin(), all.end(), [](const Kept& a, const Kept& b) { return a.used < b.used; });
  for (const Kept& kept : all) {
    if (sum <= most) return;
    std::error_code gone;
    fs::remove(kept.file, gone);
    sum -= kept.bytes;
  }
}

std::set<std::string> lines_of(const std::string& text) {
  std::set<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.insert(line);
  return lines;
}

}  // namespace

fs::path ProgramCache::folder_of_user() {
  const auto value = [](const char* name) {
    const char* const set = std::getenv(name);
    return std::string(set ? set : "");
  };
  if (const std::string wish = value("ARKMESH_CACHE"); wish == "off")
    return {};
  else if (!wish.empty())
    throw ProgramError(fmt::format("the environment's ARKMESH_CACHE is \"{}\"; it can be off, or not be set", wish));
  fs::path base = value("XDG_CACHE_HOME");
  if (!base.is_absolute()) {
    base = value("HOME");
    if (!base.is_absolute()) return {};
    base /= ".cache";
  }
  return base / "arkmesh" / "controllers";
}

ProgramCache::ProgramCache(fs::path folder, const ReadProgram& program)
    : folder_(std::move(folder)), program_(program), key_(folder_.empty() ? "" : key()) {
  // files of most systems tell the last few milliseconds no better: too early to have been read by a compiler
  clock_gettime(CLOCK_REALTIME, &begin_);
}

std::string ProgramCache::key() const {
  ContentHash hash;
  utsname machine{};
  uname(&machine);  // a home may be shared by machines; no option of ours depends on more than the family
  hash.add(machine.machine);
  for (const std::string& part : ObjectBuild::recipe(program_)) hash.add(part);
  for (const auto& [path, text] : program_.files) {
    hash.add(path.string());  // as in the program's __FILE__
    hash.add(text);
  }
  for (const char* name : deciding_variables) {
    const char* const value = std::getenv(name);
    hash.add(value ? value : "\n");
  }
  for (const char* name : {"cc", "as", "ld"}) {
    const std::string file = found_in_path(name);
    hash.add(file);
    hash.add(age_of(file));
  }
  std::set<std::string> library;
  for (const fs::path& folder : {kilolib_folder(), firmware_folder()})
    for (const auto& entry : fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied))
      if (entry.is_regular_file()) library.insert(entry.path().string());
  for (const std::string& file : library) {
    hash.add(file);
    hash.add(content_of(file));
  }
  return hash.name();
}

fs::path ProgramCache::object_file(const std::set<std::string>& inputs) const {
  ContentHash hash;
  hash.add(key_);
  for (const std::string& input : inputs) {
    hash.add(input);
    if (input.starts_with(by_age)) {
      hash.add(age_of(input.substr(1)));
    } else {
      const bool there = access(input.c_str(), F_OK) == 0;
      hash.add(there ? "there" : "absent");
      if (there) hash.add(content_of(input));
    }
  }
  return folder_ / (hash.name() + ".so");
}

std::optional<fs::path> ProgramCache::find() const {
  if (folder_.empty() || !trusted(folder_)) return {};
  const std::set<std::string> list = lines_of(content_of(inputs_file()));
  if (list.empty()) return {};
  const fs::path object = object_file(list);
  const std::string content = content_of(object);
  if (content.size() <= ContentHash::digits) return {};
  const std::string_view all(content), body = all.substr(0, all.size() - ContentHash::digits);
  if (all.substr(body.size()) != seal_of(object, body)) return {};
  // used now
  for (const fs::path& file : {object, inputs_file()}) utimensat(AT_FDCWD, file.c_str(), nullptr, 0);
  return object;
}

void ProgramCache::keep(const ObjectBuild& build, std::uintmax_t most) const {
  if (folder_.empty()) return;
  std::vector<std::string> read = paths_in_rules(content_of(build.rules()));
  // a compiler that does not tell what it reads
  if (std::find(read.begin(), read.end(), (kilolib_folder() / "kilolib.h").string()) == read.end()) return;
  // rules do not name the files that include the others
  for (const fs::path& compiled : build.compiled()) read.push_back(compiled.string());

  std::set<std::string> inputs;
  for (const ReadProgram::File& file : program_.files) inputs.merge(inputs_of(read, program_.folders_for(file.path)));
  // the key has them
  for (const fs::path& known : {build.work(), kilolib_folder(), firmware_folder()})
    std::erase_if(inputs, [&](const std::string& path) { return path.starts_with(known.string() + "/"); });
  for (const std::string& path : inputs) {
    if (path.find('\n') != std::string::npos) return;
    // changed while the compiler read
    struct stat about {};
    if (stat(path.c_str(), &about) == 0 &&
        std::pair(about.st_ctim.tv_sec, about.st_ctim.tv_nsec) > std::pair(begin_.tv_sec, begin_.tv_nsec))
      return;
    const std::string content = content_of(path);
    for (const char* word : of_the_moment)
      if (content.find(word) != std::string::npos) return;
  }
  for (const char* word : of_the_moment)
    if (program_.says(word)) return;
  for (const char* name : {"cc1", "as", "ld"})
    if (const std::string part = part_of_compiler(name); !part.empty()) inputs.insert(part);

  if (key() != key_) return;

  std::error_code error;
  if (fs::create_directories(folder_, error)) fs::permissions(folder_, fs::perms::owner_all, error);
  if (error) return warn_once(folder_, fmt::format("cannot be made ({})", error.message()));
  if (!trusted(folder_)) return warn_once(folder_, "can be written by others");
  inputs.merge(lines_of(content_of(inputs_file())));
  std::string list;
  for (const std::string& path : inputs) list += path + "\n";
  const fs::path object = object_file(inputs);
  std::string content = content_of(build.object());
  content += seal_of(object, content);
  for (const auto& [file, says] : {std::pair(object, &content), std::pair(inputs_file(), &list)})
    if (const int reason = hal::replace_file(file, *says); reason != 0)
      return warn_once(folder_, fmt::format("cannot be written ({})", std::strerror(reason)));
  trim(folder_, most);
}

}  // namespace arkmesh::sim_ode
