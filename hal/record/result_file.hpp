// result.json of a run's folder. What it says of the run's outcome is written and read here alone, and so is the rule
// for whether the run still goes on. It lies in hal/ because labs write it, and readers of recordings, which know no
// labs, read it. The file is replaced as a whole, so that a reader and a crash find the old one or the new one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/record/outcome.hpp"

namespace arkmesh::hal {

// Of what a result.json says, which anybody may have written. Nothing: it says no outcome that there is.
std::optional<Outcome> outcome_in(const nlohmann::json& result);
// Why the run ended, in one sentence; empty when that is not said.
std::string ended_in(const nlohmann::json& result);
// Makes a result say both. `ended` may be empty where the outcome's word says all.
void set_outcome(nlohmann::json& result, Outcome outcome, std::string_view ended = {});

class ResultFile {
 public:
  enum class Runs : std::uint8_t {
    no,
    yes,
    unknown,  // on another machine, or nobody knows where
  };

  // What the folder's result.json says now. One that is no JSON object, no regular file or above 64 MB counts as none.
  explicit ResultFile(const std::filesystem::path& folder);

  // Null when there is none.
  const nlohmann::json& content() const { return content_; }
  bool exists() const { return content_.is_object(); }
  std::optional<Outcome> outcome() const { return outcome_in(content_); }
  std::string ended() const { return ended_in(content_); }
  // Empty when there is no such text.
  std::string text(const char* key) const;
  // The names in `labs` that can be names of folders.
  std::vector<std::string> labs() const;
  // Whether the run goes on: its outcome is `running`, and the process that wrote so lives. A process is known by its
  // id, its host and when it began, for ids are used again.
  Runs runs() const;
  // "the run of shark (process 12), which still goes on"; empty when it certainly does not.
  std::string goes_on_in_words() const;
  // When the run goes on no more and did not say so: the file says `killed` from now on. False: not so.
  bool mark_killed();

 private:
  const nlohmann::json& process() const;
  std::int64_t process_id() const;  // 0: none is named

  std::filesystem::path file_;
  nlohmann::json content_;
};

// Returns errno, 0 when the file is replaced.
int replace_json(const std::filesystem::path& file, const nlohmann::json& json);
// Of a run that has begun: what is known of it, and that it is running. As replace_json().
int save_running(const std::filesystem::path& file, nlohmann::json facts);
// What cannot be written goes to the standard output; of a run's result the file then says its outcome, if it can.
void save_json(const std::filesystem::path& file, const nlohmann::json& json);

// Who runs in this process: the facts by which others find out whether it still does.
nlohmann::json own_process();

}  // namespace arkmesh::hal
