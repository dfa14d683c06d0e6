// `arkmesh guide`: what to do next, from what lies in a folder and what runs on this machine.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "hal/config/config.hpp"
#include "hal/files/own_files.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_shown = 3;               // of each kind
constexpr std::uintmax_t largest_source = 1 << 20;  // bytes; what is larger is no source

struct Step {
  std::string command, what_it_does;
};

std::string typed_as(const fs::path& path) {
  std::string text = path.string();
  const bool plain = text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+,=@") ==
                     std::string::npos;
  if (plain && !text.starts_with('-')) return text;
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string text_of(const fs::path& file) {
  std::error_code ignored;
  if (fs::file_size(file, ignored) > largest_source || ignored) return "";
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Whether a line of it begins so, behind blanks.
bool has_line(std::string_view text, std::string_view begin) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(at, end - at);
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.starts_with(begin)) return true;
    at = end + 1;
  }
  return false;
}

// What lies in a folder that arkmesh has something to do with, by name; runs and batches newest first.
struct Findings {
  std::vector<fs::path> programs, scenarios, labs, batches, runs, batch_results;

  bool is_empty() const {
    return programs.empty() && scenarios.empty() && labs.empty() && batches.empty() && runs.empty() &&
           batch_results.empty();
  }
};

void look_at_folder(const fs::path& folder, Findings& found) {
  std::error_code ignored;
  if (fs::exists(folder / "runs.csv", ignored))
    found.batch_results.push_back(folder);
  else if (fs::exists(folder / "result.json", ignored))
    found.runs.push_back(folder);
}

void look_at_file(const fs::path& file, Findings& found) {
  const std::string kind = file.extension().string();
  if (kind != ".c" && kind != ".py" && kind != ".toml") return;
  const std::string text = text_of(file);
  if (kind == ".c" && text.find("kilo_start") != std::string::npos) found.programs.push_back(file);
  if (kind == ".py" && text.find("arkmesh.Scenario") != std::string::npos) found.scenarios.push_back(file);
  if (kind == ".toml" && has_line(text, "[lab]")) found.labs.push_back(file);
  if (kind == ".toml" && has_line(text, "seeds") && has_line(text, "labs")) found.batches.push_back(file);
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code failed;
  for (fs::directory_iterator at(folder, fs::directory_options::skip_permission_denied, failed), end;
       !failed && at != end; at.increment(failed))
    out.push_back(at->path().lexically_normal());
  std::ranges::sort(out);
  return out;
}

void newest_first(std::vector<fs::path>& folders) {
  std::ranges::stable_sort(folders, std::greater(), [](const fs::path& folder) {
    std::error_code ignored;
    return fs::last_write_time(folder, ignored);
  });
}

Findings look(const fs::path& folder) {
  Findings found;
  look_at_folder(folder, found);
  std::error_code ignored;
  for (const fs::path& entry : entries_of(folder)) {
    if (fs::is_regular_file(entry, ignored)) look_at_file(entry, found);
    if (fs::is_directory(entry, ignored)) look_at_folder(entry, found);
  }
  for (const fs::path& entry : entries_of(folder / "runs"))
    if (fs::is_directory(entry, ignored)) look_at_folder(entry, found);
  newest_first(found.runs);
  newest_first(found.batch_results);
  return found;
}

// The command lines of labs, gateways and long work that run on this machine, as typed.
std::vector<std::vector<std::string>> running() {
  std::vector<std::vector<std::string>> out;
  for (const fs::path& process : entries_of("/proc")) {
    std::ifstream in(process / "cmdline", std::ios::binary);
    std::vector<std::string> words;
    for (std::string word; words.size() < 64 && std::getline(in, word, '\0');) words.push_back(word);
    if (words.size() < 3 || !fs::path(words[0]).filename().string().starts_with("arkmesh")) continue;
    for (const char* const name : {"lab", "gateway", "run", "batch", "up"})
      if (words[1] == name) out.push_back({words.begin() + 1, words.end()});
  }
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());  // clang 14 does not compile that of std::ranges
  return out;
}

// `all`: how many there are, of which no more than most_shown are named; 0: all are.
// Whether the program that runs this command was built, or installed.
bool is_there(const Step& step) {
  constexpr std::string_view ours = "arkmesh ";
  const std::string name = step.command.substr(std::min(ours.size(), step.command.size()));
  const CommandRow* const row = step.command.starts_with(ours) ? find_command(name.substr(0, name.find(' '))) : nullptr;
  return !row || name.starts_with("config ") || fs::exists(hal::program_folder() / row->program);
}

void say(const std::string& heading, std::size_t all, std::vector<Step> steps) {
  std::erase_if(steps, [](const Step& step) { return !is_there(step); });
  if (steps.empty()) return;
  fmt::print("{}{}:\n", heading, all > most_shown ? fmt::format(" (and {} more)", all - most_shown) : "");
  std::size_t width = 0;
  for (const Step& step : steps) width = std::max(width, step.command.size());
  width = std::min<std::size_t>(width, 60);
  for (const Step& step : steps) fmt::print("  {:<{}}  {}\n", step.command, width, step.what_it_does);
  fmt::print("\n");
}

// A step for each of the first: `command` with {} for the file.
std::vector<Step> each(const std::vector<fs::path>& found, const char* command, const std::string& what_it_does) {
  std::vector<Step> steps;
  for (const fs::path& file : std::span(found).first(std::min(found.size(), most_shown)))
    steps.push_back({fmt::format(fmt::runtime(command), typed_as(file)), what_it_does});
  return steps;
}

// Labs whose files lie here run together when they name each other; a file that cannot be read is said to be so.
std::vector<Step> steps_with_labs(const std::vector<fs::path>& labs) {
  std::vector<Step> steps;
  std::vector<std::pair<std::string, std::vector<fs::path>>> worlds;  // files, by the labs that take part
  fs::path with_peers;                                                // the first that names some
  for (const fs::path& file : labs) {
    try {
      const hal::Config config = hal::Config::from_file(file);
      const auto name = config.root().section("lab").get("name", std::string());
      auto together = config.root().section("shared").get("labs", std::vector<std::string>{name});
      std::ranges::sort(together);
      const std::string key =
          fmt::format("{}/{}", config.root().section("run").get("scenario", std::string()), fmt::join(together, ","));
      auto world = std::ranges::find(worlds, key, &std::pair<std::string, std::vector<fs::path>>::first);
      if (world == worlds.end()) world = worlds.insert(worlds.end(), {key, {}});
      world->second.push_back(file);
      if (with_peers.empty() && !config.root().section("gateway").section("peers", 0).place("lab").empty())
        with_peers = file;
    } catch (const std::exception& error) {
      steps.push_back({"arkmesh config --keys", fmt::format("cannot be read: {}", error.what())});
    }
  }
  for (const auto& [_, files] : worlds) {
    std::string words;
    for (const fs::path& file : files) words += " " + typed_as(file);
    steps.push_back({"arkmesh run" + words, "as fast as possible, into a folder below runs/"});
    steps.push_back({fmt::format("arkmesh run{} --open", words), "the same in a browser, in real time"});
    if (steps.size() >= 2 * most_shown) break;
  }
  if (!worlds.empty())
    steps.push_back(
        {"arkmesh doctor " + typed_as(worlds[0].second[0]), "lists problems that would prevent a run, with remedies"});
  if (!with_peers.empty())
    steps.push_back({"arkmesh up " + typed_as(with_peers), "with a gateway, joined to the remote labs that it names"});
  return steps;
}

std::vector<Step> steps_with_running() {
  std::vector<Step> steps;
  for (const std::vector<std::string>& words : running()) {
    const std::string typed = fmt::format("it runs: arkmesh {}", fmt::join(words, " "));
    if (words[0] == "run" || words[0] == "batch" || words[0] == "up") {
      steps.push_back({"", typed});
      continue;
    }
    steps.push_back({"arkmesh status " + typed_as(words[1]), typed});
    if (words[0] != "lab") continue;
    steps.push_back({"arkmesh view " + typed_as(words[1]), "shows it in a browser"});
    steps.push_back({"arkmesh stop " + typed_as(words[1]), "ends it and writes its results"});
  }
  return steps;
}

std::vector<Step> steps_with_runs(const std::vector<fs::path>& runs) {
  std::vector<Step> steps = each(runs, "arkmesh view {}", "shows it in a browser");
  if (runs.empty()) return steps;
  const std::string newest = typed_as(runs[0]);
  steps.push_back({"arkmesh plot " + newest, "draws its end"});
  steps.push_back({fmt::format("arkmesh export {} --csv", newest), "tables of everything recorded; or --hdf5, --mp4"});
  steps.push_back({"arkmesh rerun " + newest, "repeats it and compares the results"});
  return steps;
}

std::vector<Step> steps_with_programs(const std::vector<fs::path>& programs) {
  std::vector<Step> steps = each(programs, "arkmesh controller run {} --open", "runs a swarm of it, live in a browser");
  if (!programs.empty())
    steps.push_back({"arkmesh controller check " + typed_as(programs[0]), "checks that it fits a Kilobot"});
  return steps;
}

void guide(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw hal::ConfigError(fmt::format("{}: is not a folder", folder.string()));
  say("Running on this machine", 0, steps_with_running());
  const Findings found = look(folder);
  say("Runs, newest first", found.runs.size(), steps_with_runs(found.runs));
  say("Results of batches", found.batch_results.size(),
      each(found.batch_results, "column -s, -t {}/summary.csv",
           "means with their intervals; runs.csv beside it has each run"));
  say("Labs' files", 0, steps_with_labs(found.labs));
  say("Batches to run", found.batches.size(),
      each(found.batches, "arkmesh batch {}", "runs or resumes its grid of settings and seeds"));
  say("Scenarios in Python", found.scenarios.size(),
      each(found.scenarios, "arkmesh config --keys {}", "lists its settings; a lab's file names it as run.scenario"));
  say("Robots' programs", found.programs.size(), steps_with_programs(found.programs));
  if (!found.is_empty()) return;
  fmt::print("{} holds no arkmesh files yet.\n\n", folder == "." ? "This folder" : typed_as(folder));
  say("To begin", 0,
      {{"arkmesh scenario new my_swarm", "an experiment of two labs in Python, ready to run, in the folder my_swarm"},
       {"arkmesh config --sample > lab.toml", "a lab's file with every key, commented; arkmesh run lab.toml runs it"},
       {"arkmesh doctor", "lists what this machine lacks"}});
  // The package arkmesh-doc may not be there.
  const fs::path course = hal::own_file("../doc/arkmesh/html/docs/learn-scenario.html", "docs/learn-scenario.md");
  std::error_code ignored;
  if (fs::exists(course, ignored))
    fmt::print("Ten minutes to a first result of your own: {}\n", course.lexically_normal().string());
}

}  // namespace

void add_guide_command(CLI::App* command) {
  const auto folder = std::make_shared<std::string>(".");
  command->add_option("FOLDER", *folder, "The folder to inspect (default: the current one)");
  command->footer("Examples:\n  arkmesh guide\n  arkmesh guide ~/experiments/aggregation");
  command->callback([folder] { guide(*folder); });
}

}  // namespace arkmesh::cli
