#include "lab/run_folder.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>

#include "hal/files/replace_file.hpp"
#include "hal/handle.hpp"
#include "hal/record/event_log.hpp"
#include "hal/record/result_file.hpp"
#include "lab/result.hpp"

namespace arkmesh::lab {

namespace fs = std::filesystem;

namespace {

constexpr off_t reserve_bytes = 256 << 10;

// Wall microseconds since 1970: what lab time 0 stands for in a recording until it begins.
std::int64_t wall_utime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

// A run that is about to write here as well finds the file there.
fs::path take(const fs::path& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  const fs::path file = directory / "result.json";
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (descriptor < 0 && errno == EEXIST)
    throw hal::ConfigError(fmt::format("{} holds another run; give another folder with --out", directory.string()));
  if (descriptor < 0)
    throw std::runtime_error(
        fmt::format("cannot record in {}: {}; choose another directory", directory.string(), std::strerror(errno)));
  ::close(descriptor);
  return directory;
}

// Returns errno. Where room cannot be kept there may be some all the same.
int make_room(const fs::path& file, std::uint64_t keep_free_bytes) {
  if (std::error_code error; fs::space(file.parent_path(), error).available < keep_free_bytes) return ENOSPC;
  const hal::Handle handle(::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644));
  if (!handle) return errno;
  const int error = ::posix_fallocate(handle.get(), 0, reserve_bytes);
  return error == ENOSPC || error == EDQUOT ? error : 0;
}

// In the folders of `directory`, and in those of their labs.
void mark_killed_in(const fs::path& directory) {
  std::error_code error;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code unknown;
    if (!entry->is_directory(unknown)) continue;
    hal::ResultFile result(entry->path());
    if (!result.mark_killed()) continue;
    for (const std::string& lab : result.labs()) hal::ResultFile(entry->path() / lab).mark_killed();
  }
}

}  // namespace

RunFolder::RunFolder(const fs::path& directory, const std::string& effective_config, hal::Recorder::Options options,
                     const nlohmann::json& facts)
    : recorder_(take(directory), wall_utime(), options), reserve_(directory / "reserve.tmp") {
  int error = hal::replace_file(directory / "config.toml", effective_config);
  if (error == 0) error = hal::save_running(directory / "result.json", facts);
  if (error == 0) error = make_room(reserve_, options.keep_free_bytes);
  if (error == 0) return;
  std::error_code gone;
  for (const char* name : {"config.toml", "result.json", "reserve.tmp", hal::log_name, hal::packed_log_name})
    fs::remove(directory / name, gone);
  throw std::runtime_error(
      fmt::format("cannot record in {}: {}; make room there (recorder.keep_free_mib = {} stays free), or choose "
                  "another directory with --out",
                  directory.string(), std::strerror(error), options.keep_free_bytes >> 20));
}

RunFolder::~RunFolder() {
  std::error_code gone;
  fs::remove(reserve_, gone);
}

void RunFolder::save_result(const nlohmann::json& result) const {
  const fs::path file = directory() / "result.json";
  if (hal::replace_json(file, result) == 0) return;
  std::error_code gone;
  fs::remove(reserve_, gone);
  hal::save_json(file, result);
}

void RecorderConfig::fields(const hal::Section& recorder) {
  recorder.field("log", log, {.help = "write log.lcm; tables are always written"});
  recorder.field("compress", compress,
                 {.help = "write log.lcm.zst instead, with a zstd frame for each period: 2 to 5 times smaller; `zstd "
                          "-d` unpacks it for lcm-logplayer"});
  recorder.field("keep_free_mib", keep_free_mib,
                 {.range = {0, 1 << 20},
                  .unit = "MiB",
                  .help = "recording stops when less disk space is left; the run continues"});
  recorder.field("fast_mb_per_s", fast_mb_per_s,
                 {.range = {1e-3, 1e6},
                  .unit = "MB/s",
                  .help = "a warning names the largest channel when log.lcm, uncompressed, grows faster than this over "
                          "10 s of wall or lab time, whichever is longer"});
}

hal::Recorder::Options RecorderConfig::options() const {
  return {.log = log,
          .compress = compress,
          .keep_free_bytes = static_cast<std::uint64_t>(keep_free_mib) << 20,
          .fast_bytes_per_s = fast_mb_per_s * 1e6};
}

fs::path default_run_directory(const std::string& name) {
  const std::string first = fmt::format("runs/{:%Y%m%d-%H%M%S}-{}", fmt::localtime(std::time(nullptr)), name);
  fs::path directory = first;
  for (int number = 2; fs::exists(directory); ++number) directory = fmt::format("{}-{}", first, number);
  return directory;
}

void claim_run_folder(const fs::path& directory, bool force) {
  std::error_code error;
  const fs::path own = fs::absolute(directory / "").lexically_normal().parent_path();
  mark_killed_in(own.parent_path());
  if (fs::exists(own, error) && !fs::is_directory(own, error))
    throw hal::ConfigError(fmt::format("{} is a file; give a folder with --out", directory.string()));
  if (fs::exists(own, error) && !fs::is_empty(own, error)) {
    if (const std::string run = hal::ResultFile(own).goes_on_in_words(); !run.empty())
      throw hal::ConfigError(
          fmt::format("{} is the folder of {}; give another one with --out", directory.string(), run));
    if (!force)
      throw hal::ConfigError(fmt::format("{} is not empty; give another folder with --out, or --force to move it aside",
                                         directory.string()));
    if (const fs::path way = fs::current_path(error).lexically_relative(own); !way.empty() && *way.begin() != "..")
      throw hal::ConfigError(fmt::format("{} is the current folder; give another one with --out", directory.string()));
    fs::path aside;
    for (int number = 1; aside.empty() || fs::exists(aside); ++number)
      aside = fmt::format("{}.{}", own.string(), number);
    fs::rename(own, aside);
  }
  fs::create_directories(own, error);
  if (error)
    throw std::runtime_error(
        fmt::format("cannot record in {}: {}; choose another directory", directory.string(), error.message()));
}

}  // namespace arkmesh::lab
