// `arkmesh batch` as a process, on experiments of eight robots for 40 s, so that a batch takes seconds.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::tests {

inline const std::string small_labs = "labs = [\"" ARKMESH_SOURCE_DIR "/experiments/dhtf/shark.toml\"]\n";
inline const std::string small_batch = small_labs +
                                       "seeds = \"1..4\"\n[set]\nrun.duration_s = 40\narena.robots = 8\n"
                                       "[sweep]\ngate.period_s = [1, 2]\nscenario.dhtf.types = [\"easy\", \"hard\"]\n";

struct BatchBench {
  TemporaryDirectory folder;
  int said = 0;

  std::filesystem::path file(const std::string& text, const std::string& name = "small.toml") {
    return folder.write(name, text);
  }
  Process start(const std::vector<std::string>& words) {
    return Process(ARKMESH_PROGRAM, words, folder.path() / fmt::format("said-{}.txt", ++said));
  }
  // Exit code, and what was said.
  std::pair<int, std::string> run(const std::vector<std::string>& words) {
    Process process = start(words);
    const int code = process.wait(std::chrono::seconds(120)).value_or(-1);
    return {code, process.output()};
  }
  std::pair<int, std::string> batch(const std::filesystem::path& file, const std::string& out,
                                    std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"batch", file.string(), "--out", (folder.path() / out).string()};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
  std::string table(const std::string& out, const std::string& name = "runs.csv") const {
    return read_file(folder.path() / out / name);
  }
};

// Rows of a table, without its header.
inline long rows(const std::string& table) {
  return std::ranges::count(table, '\n') - 1;
}

}  // namespace arkmesh::tests
