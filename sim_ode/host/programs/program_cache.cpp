// One file for each program: an object with a hash at its end, under the hash of the program as the compiler reads it.
// To know that name a program is preprocessed each time.
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

#include "hal/files/replace_file.hpp"
#include "sim_ode/host/programs/content_hash.hpp"
#include "sim_ode/host/programs/program_inputs.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

// What compilers read beside their arguments, and what of it is not in a preprocessed program.
constexpr const char* deciding_variables[] = {"LIBRARY_PATH", "COMPILER_PATH", "GCC_EXEC_PREFIX"};

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
    if (kept.file.extension() == ".so") {
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

ProgramCache::ProgramCache(fs::path folder, ObjectBuild& build) : folder_(std::move(folder)), build_(build) {
  const std::vector<std::string> parts = folder_.empty() ? std::vector<std::string>() : build.decided_by();
  if (parts.empty()) return;
  ContentHash hash;
  utsname machine{};
  uname(&machine);  // a home may be shared by machines; no option of ours depends on more than the family
  hash.add(machine.machine);
  for (const std::string& part : parts) hash.add(part);
  for (const char* name : deciding_variables) {
    const char* const value = std::getenv(name);
    hash.add(value ? value : "\n");
  }
  for (const char* name : {"cc", "as", "ld"}) {
    const std::string file = found_in_path(name);
    hash.add(file);
    hash.add(age_of(file));
  }
  object_ = folder_ / (hash.name() + ".so");
}

std::optional<fs::path> ProgramCache::find() const {
  if (object_.empty() || !trusted(folder_)) return {};
  const std::string content = content_of(object_);
  if (content.size() <= ContentHash::digits) return {};
  const std::string_view all(content), body = all.substr(0, all.size() - ContentHash::digits);
  if (all.substr(body.size()) != seal_of(object_, body)) return {};
  utimensat(AT_FDCWD, object_.c_str(), nullptr, 0);  // used now
  return object_;
}

void ProgramCache::keep(std::uintmax_t most) const {
  if (object_.empty()) return;
  std::error_code error;
  if (fs::create_directories(folder_, error)) fs::permissions(folder_, fs::perms::owner_all, error);
  if (error) return warn_once(folder_, fmt::format("cannot be made ({})", error.message()));
  if (!trusted(folder_)) return warn_once(folder_, "can be written by others");
  std::string content = content_of(build_.object());
  content += seal_of(object_, content);
  if (const int reason = hal::replace_file(object_, content); reason != 0)
    return warn_once(folder_, fmt::format("cannot be written ({})", std::strerror(reason)));
  trim(folder_, most);
}

}  // namespace arkmesh::sim_ode
