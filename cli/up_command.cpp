// `arkmesh up`: the labs and gateways of some files as children of one process, which end together.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/child_processes.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "hal/config.hpp"

namespace arkmesh::cli {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// After one has failed, for the others to notice by themselves and say why.
constexpr auto others_notice_within = 8s;

struct UpOptions {
  std::vector<std::string> files, sets;
  std::string out;
  bool force = false;
};

struct LabOfFile {
  std::string name;
  std::size_t lab = 0, gateway = 0;
};

class Group {
 public:
  explicit Group(const UpOptions& options) {
    for (const std::string& file : options.files) {
      const hal::Section root = hal::Config::from_file(file, options.sets).root();
      const std::string name = root.section("lab").get("name", std::string(), {.required = true});
      if (std::ranges::find(labs_, name, &LabOfFile::name) != labs_.end())
        throw hal::ConfigError(fmt::format("{}: lab '{}' is given twice; each file must name another lab", file, name));
      labs_.push_back({.name = name});
    }
    for (std::size_t i = 0; i < labs_.size(); ++i) start(options, options.files[i], labs_[i]);
  }

  // Returns the exit code: of a lab that did not finish, the first in the files' order.
  int run() {
    OperatorStop stop;
    while (goes_on()) {
      children_.serve(100ms);
      for (const LabOfFile& lab : labs_) look_after(lab);
      if (stop.stopped())
        stop_labs(SIGTERM);
      else if (end_at_ && Clock::now() >= *end_at_)
        stop_labs(group_failed_signal);
    }
    for (const LabOfFile& lab : labs_) children_.signal(lab.gateway, SIGTERM);
    for (const auto until = Clock::now() + 5s; Clock::now() < until && !all_ended();) children_.serve(100ms);
    for (const LabOfFile& lab : labs_)
      if (const int code = *children_[lab.lab].code; code != 0) return code > 128 ? 1 : code;
    return 0;
  }

 private:
  void start(const UpOptions& options, const std::string& file, LabOfFile& lab) {
    std::vector<std::string> sets;
    for (const std::string& set : options.sets) sets.insert(sets.end(), {"--set", set});
    const auto words = [&](const char* command, std::vector<std::string> more) {
      more.insert(more.begin(), {command, file});
      more.insert(more.end(), sets.begin(), sets.end());
      return more;
    };
    lab.gateway = children_.start(lab.name + " gateway", words("gateway", {}));
    std::vector<std::string> more;
    if (!options.out.empty()) more = {"--out", (std::filesystem::path(options.out) / lab.name).string()};
    if (options.force) more.push_back("--force");
    lab.lab = children_.start(lab.name, words("lab", more));
  }

  void look_after(const LabOfFile& lab) {
    const auto& gateway = children_[lab.gateway];
    if (gateway.code && !end_at_) {
      fmt::print(stderr, "arkmesh: the gateway of {} has ended with code {}; the labs are stopped\n", lab.name,
                 *gateway.code);
      end_at_ = Clock::now();
    }
    const auto& code = children_[lab.lab].code;
    if (code.value_or(0) == 0 || end_at_) return;
    fmt::print(stderr, "arkmesh: lab {} has ended with code {}; the others are stopped within {} s\n", lab.name, *code,
               others_notice_within.count());
    end_at_ = Clock::now() + others_notice_within;
  }

  void stop_labs(int signal) {
    if (stopped_) return;
    stopped_ = true;
    for (const LabOfFile& lab : labs_) children_.signal(lab.lab, signal);
  }

  bool goes_on() const {
    return std::ranges::any_of(labs_, [&](const LabOfFile& lab) { return !children_[lab.lab].code; });
  }
  bool all_ended() const {
    for (std::size_t i = 0; i < children_.size(); ++i)
      if (!children_[i].code) return false;
    return true;
  }

  std::vector<LabOfFile> labs_;
  ChildProcesses children_;
  std::optional<Clock::time_point> end_at_;
  bool stopped_ = false;
};

}  // namespace

void add_up_command(CLI::App* command) {
  auto options = std::make_shared<UpOptions>();
  command->add_option("files", options->files, "A configuration file for each lab of this machine")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--out", options->out, "Folder for the results, one folder in it for each lab");
  command->add_flag("--force", options->force, "Move what a lab's folder holds aside");
  command->add_option("--set", options->sets, "Override a key of all files: --set run.seed=7")->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh up experiments/dhtf/shark.toml experiments/dhtf/roark.toml\n"
      "Ctrl-C ends all of them with their results; so does the end of one that fails.");
  command->callback([options] { end_with(Group(*options).run()); });
}

}  // namespace arkmesh::cli
