// The page of recorded runs: one run, the runs of a batch, or two runs side by side. Answers what view/PROTOCOL.md
// lets a viewer ask; commands nothing.
#pragma once

#include <chrono>
#include <filesystem>
#include <list>
#include <optional>
#include <string>
#include <vector>

#include "recording/run.hpp"
#include "recording/view/run_story.hpp"
#include "view/server.hpp"

namespace arkmesh::recording {

class RecordedDesk final : public view::Desk {
 public:
  // One folder of a run or of a batch, or two of runs. Of a batch each request names its run, the first one if it names
  // none; 32 runs are open at a time. Throws hal::ConfigError with one sentence.
  explicit RecordedDesk(const std::vector<std::filesystem::path>& folders);

  nlohmann::json about() override;
  void command(const nlohmann::json& what, view::Answer& answer) override;
  void request(const nlohmann::json& what, view::Answer& answer) override;
  // What the user should know of what was shown last: cut logs, other versions, whether two runs differ. One sentence
  // each.
  std::vector<std::string> notes() const;

 private:
  struct Lab {
    const RecordedLab* lab;
    std::string name;  // as viewers know it
  };
  // What a viewer looks at: a run of the batch, or all that was given.
  struct Opened {
    std::size_t number = 0;  // as viewers name it: of a run of the batch, else 0
    std::vector<Run> runs;
    std::vector<Lab> labs;
    std::optional<Comparison> comparison;
    bool is_growing = false;
    std::chrono::steady_clock::time_point taken{};

    Opened(const std::vector<std::filesystem::path>& folders, std::size_t number);
    // Of runs that still go on: takes what is new, twice a second at most.
    void take_new();
    std::int64_t length_us() const;
    std::vector<std::string> notes() const;
    void moment(const nlohmann::json& what, view::Answer& answer) const;
    void row(const nlohmann::json& what, view::Answer& answer) const;
    void events(view::Answer& answer) const;
    void series(view::Answer& answer) const;
  };
  // The run that `object` names by its member "run", opened if it is not. Throws hal::ConfigError when there is none.
  Opened& named_in(const nlohmann::json& object);
  nlohmann::json about(Opened& shown) const;
  // The table of the batch, as PROTOCOL.md has it.
  void table(view::Answer& answer) const;

  std::vector<std::filesystem::path> folders_, batch_;  // batch_: all runs of it; empty: none
  std::list<Opened> opened_;                            // what was used last comes first
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
