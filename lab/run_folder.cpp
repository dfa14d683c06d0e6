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

hal::Recorder::Options read_recorder_options(const hal::Section& recorder) {
  return {.log = recorder.flag("log", true),
          .keep_free_bytes = static_cast<std::uint64_t>(recorder.integer("keep_free_mib", 64, 0, 1 << 20)) << 20};
}

std::filesystem::path default_run_directory() {
  return fmt::format("runs/{:%Y%m%d-%H%M%S}", fmt::localtime(std::time(nullptr)));
}

}  // namespace arkmesh::lab
