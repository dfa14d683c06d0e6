// A batch's folder: a folder for each run, the manifest, and who is at work in it. One batch at a time, or any number
// of processes that do single runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace arkmesh::app {

class BatchFolder {
 public:
  enum class Use : std::uint8_t { alone, single_runs, looking };
  // Makes the folder, or takes one that was begun with the same manifest. Throws ConfigError when it holds something
  // else (to look at, nothing), was begun with another one, or is at work elsewhere; std::runtime_error when it cannot
  // be written.
  BatchFolder(std::filesystem::path directory, const nlohmann::json& manifest, Use use);
  ~BatchFolder();
  BatchFolder(const BatchFolder&) = delete;
  BatchFolder& operator=(const BatchFolder&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  std::filesystem::path run(std::size_t number) const { return run_folder(directory_, number); }
  // Keeps one run to this process while it lives. False: another one has it.
  bool take_run(std::size_t number);
  static std::filesystem::path run_folder(const std::filesystem::path& batch, std::size_t number);

 private:
  void take(Use use);

  std::filesystem::path directory_;
  int runs_lock_ = -1;  // a byte for each run
  int lock_ = -1;       // children inherit it: while one lives, nobody else is at work here
};

}  // namespace arkmesh::app
