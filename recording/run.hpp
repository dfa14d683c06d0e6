// The folder of a run, of one lab or several, as its readers see it: labs with their logs and tables. A folder may be
// of another machine, of another version, cut short, or of a run that still goes on; what is there is used, and what is
// not is said.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "recording/log.hpp"

namespace arkmesh::recording {

struct RecordedLab {
  std::string name;  // as its result says, or of its folder; each once in a run
  std::filesystem::path folder;
  std::unique_ptr<Log> log;
  std::string version;  // of the arkmesh that made it, as its result says; may be empty
};

class Run {
 public:
  // `folder`: of a run of several labs, or of one lab. Throws hal::ConfigError with one sentence when it is neither, or
  // of a batch.
  explicit Run(const std::filesystem::path& folder);

  const std::filesystem::path& folder() const { return folder_; }
  // The last part of the folder's name.
  std::string name() const;
  // In the order of names.
  const std::vector<RecordedLab>& labs() const { return labs_; }
  // Of the longest log.
  std::int64_t length_us() const;
  // Whether the process of a lab still writes here.
  bool is_growing() const;
  // Takes what a run that goes on has written since. True when there was something.
  bool refresh();
  // What readers should know, one sentence each: logs that are cut or out of order, folders that cannot be read,
  // channels of another version.
  std::vector<std::string> notes() const;

 private:
  std::filesystem::path folder_;
  std::vector<RecordedLab> labs_;
  std::vector<std::string> left_out_;  // folders that may not be looked into
};

// The folder of a run: there is a log in it, or one level below.
bool is_run(const std::filesystem::path& folder);

// The run folders of a batch, in order: `arkmesh batch`. Empty: the folder is none of a batch.
std::vector<std::filesystem::path> runs_of_batch(const std::filesystem::path& folder);

}  // namespace arkmesh::recording
