#include "lab/run_folder.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <fstream>

#include "lab/result.hpp"

namespace arkmesh::lab {
namespace {

// Wall microseconds since 1970: what lab time 0 stands for in a recording.
std::int64_t wall_utime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

RunFolder::RunFolder(const std::filesystem::path& directory, const std::string& effective_config,
                     hal::Recorder::Options options)
    : recorder_(directory, wall_utime(), options) {
  std::ofstream(directory / "config.toml") << effective_config;
}

void RunFolder::save_result(const nlohmann::json& result) const {
  write_json(directory() / "result.json", result);
}

void RecorderConfig::fields(const hal::Section& recorder) {
  recorder.field("log", log, {.help = "write log.lcm; tables are always written"});
  recorder.field(
      "keep_free_mib", keep_free_mib,
      {.range = {0, 1 << 20}, .unit = "MiB", .help = "recording stops when the disk has less left; the run goes on"});
}

hal::Recorder::Options RecorderConfig::options() const {
  return {.log = log, .keep_free_bytes = static_cast<std::uint64_t>(keep_free_mib) << 20};
}

std::filesystem::path default_run_directory() {
  return fmt::format("runs/{:%Y%m%d-%H%M%S}", fmt::localtime(std::time(nullptr)));
}

}  // namespace arkmesh::lab
