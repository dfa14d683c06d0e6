// A run as its folder tells of it, and whether another run was the same.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/record/result_file.hpp"

namespace arkmesh::app {

class RecordedRun {
 public:
  // From a run's folder, or its result.json or config.toml; or one lab's folder beside those of the other labs; or with
  // `index` a run of a batch from that one's folder or manifest.json. Throws ConfigError when it cannot be repeated.
  RecordedRun(const std::filesystem::path& place, std::optional<std::size_t> index);

  const std::vector<std::string>& config_files() const { return config_files_; }
  // Of every lab; no message log is written, and nothing else is changed.
  std::vector<hal::Config> configs() const;
  std::string final_hash() const { return result_.text("final_hash"); }
  // In words, what is not as it was: this program, or files that the run was made from. Empty: nothing.
  std::vector<std::string> changes() const;
  // Where a run in `folder` first differs, by the joint hash.csv: "period 17, lab shark"; empty when that does not
  // tell.
  std::string first_difference(const std::filesystem::path& folder) const;

 private:
  void find_labs();

  std::filesystem::path folder_;
  hal::ResultFile result_;
  std::vector<std::filesystem::path> lab_folders_;
  std::vector<std::string> config_files_;
};

}  // namespace arkmesh::app
