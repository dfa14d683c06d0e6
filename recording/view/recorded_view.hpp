// The page of recorded runs: one run, the runs of a batch, or two runs side by side. Answers what docs/view-protocol.md
// lets a viewer ask; commands nothing.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "recording/run.hpp"
#include "recording/view/run_story.hpp"
#include "view/server.hpp"

namespace arkmesh::recording {

class RecordedDesk final : public view::Desk {
 public:
  // One folder of a run or of a batch, or two of runs. Throws hal::ConfigError with one sentence.
  explicit RecordedDesk(const std::vector<std::filesystem::path>& folders);

  nlohmann::json about() override;
  void command(const nlohmann::json& what, view::Answer& answer) override;
  void request(const nlohmann::json& what, view::Answer& answer) override;
  // What the user should know: cut logs, other versions, whether two runs differ. One sentence each.
  std::vector<std::string> notes() const;

 private:
  struct Lab {
    const RecordedLab* lab;
    std::string name;  // as viewers know it
  };
  void open(const std::vector<std::filesystem::path>& folders);
  // Of runs that still go on: takes what is new, twice a second at most.
  void take_new();
  std::int64_t length_us() const;
  void moment(const nlohmann::json& what, view::Answer& answer);
  void row(const nlohmann::json& what, view::Answer& answer);

  std::vector<std::filesystem::path> batch_;  // all runs of it; empty: none
  std::vector<Run> runs_;
  std::vector<Lab> labs_;
  std::optional<Comparison> comparison_;
  bool is_growing_ = false;
  std::chrono::steady_clock::time_point taken_{};
};

// Such a page, served on a loop that outlives it.
class RecordedView {
 public:
  RecordedView(hal::EventLoop& loop, const std::vector<std::filesystem::path>& folders, view::ServerOptions options)
      : desk_(folders), server_(loop, std::move(options), desk_) {}
  std::string url() const { return server_.url(); }
  std::uint16_t port() const { return server_.port(); }
  std::vector<std::string> notes() const { return desk_.notes(); }

 private:
  RecordedDesk desk_;
  view::Server server_;
};

}  // namespace arkmesh::recording
