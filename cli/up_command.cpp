// `arkmesh up`: the labs and gateways of some files as children of one process, which end together.
#include <fmt/format.h>
#include <poll.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "hal/child_process.hpp"
#include "hal/config/config.hpp"
#include "hal/exit_code.hpp"
#include "hal/files/own_files.hpp"

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

// This program with ARGUMENTS, of which each line is printed behind a name. Should this process die, it ends with its
// result.
struct NamedChild {
  NamedChild(std::string its_name, std::vector<std::string> arguments)
      : name(std::move(its_name)), process(start_of(std::move(arguments))) {}

  static hal::ChildStart start_of(std::vector<std::string> words) {
    words.insert(words.begin(), hal::this_program().string());
    return {.command = std::move(words), .last_signal = SIGTERM};
  }

  void serve() {
    if (code) return;
    // Whether it has ended is looked up before what it said last is read.
    const auto end = process.end();
    process.read(line);
    if (end && !line.empty() && !line.ends_with('\n')) line += '\n';
    for (std::size_t at = 0; (at = line.find('\n')) != std::string::npos; line.erase(0, at + 1))
      fmt::print("{}: {}\n", name, line.substr(0, at));
    if (end && end->code == 127) fmt::print("{}: arkmesh cannot be started\n", name);
    std::fflush(stdout);
    if (end) code = end->code;
  }
  void signal(int number) const {
    if (!code) process.signal(number);
  }

  std::string name;
  hal::ChildProcess process;
  std::string line;         // what it has begun to say
  std::optional<int> code;  // 128 + signal when it was killed
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

  // Returns the exit code: that robots of any lab may walk, else of a lab that did not finish, the first in the files'
  // order.
  int run() {
    OperatorStop stop;
    while (goes_on()) {
      serve();
      for (const LabOfFile& lab : labs_) look_after(lab);
      if (stop.stopped())
        stop_labs(SIGTERM);
      else if (end_at_ && Clock::now() >= *end_at_)
        stop_labs(group_failed_signal);
    }
    for (const LabOfFile& lab : labs_) children_[lab.gateway].signal(SIGTERM);
    for (const auto until = Clock::now() + 5s; Clock::now() < until && !all_ended();) serve();
    int all = hal::Exit::done;
    for (const LabOfFile& lab : labs_) {
      const int code = *children_[lab.lab].code;
      if (code == hal::Exit::not_standing) return code;
      if (all == hal::Exit::done) all = code > 128 ? hal::Exit::failed : code;
    }
    return all;
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
    lab.gateway = children_.size();
    children_.emplace_back(lab.name + " gateway", words("gateway", {}));
    std::vector<std::string> more;
    if (!options.out.empty()) more = {"--out", (std::filesystem::path(options.out) / lab.name).string()};
    if (options.force) more.push_back("--force");
    lab.lab = children_.size();
    children_.emplace_back(lab.name, words("lab", more));
  }

  // For up to 100 ms, or until one says something.
  void serve() {
    std::vector<pollfd> outs;
    for (const NamedChild& child : children_) outs.push_back({child.process.output(), POLLIN, 0});
    ::poll(outs.data(), outs.size(), 100);
    for (NamedChild& child : children_) child.serve();
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
    for (const LabOfFile& lab : labs_) children_[lab.lab].signal(signal);
  }

  bool goes_on() const {
    return std::ranges::any_of(labs_, [&](const LabOfFile& lab) { return !children_[lab.lab].code; });
  }
  bool all_ended() const {
    return std::ranges::all_of(children_, [](const NamedChild& child) { return child.code.has_value(); });
  }

  std::vector<LabOfFile> labs_;
  std::vector<NamedChild> children_;
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
  command->add_flag("--force", options->force, "Move existing contents of a lab's folder to OUT.1");
  command->add_option("--set", options->sets, "Override a key of all files: --set run.seed=7")->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh up experiments/dhtf/shark.toml experiments/dhtf/roark.toml\n"
      "Ctrl-C ends all labs and writes their results, and so does the failure of one.");
  command->callback([options] { end_with(Group(*options).run()); });
}

}  // namespace arkmesh::cli
