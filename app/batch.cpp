#include "app/batch.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <utility>

#include "app/joint_run.hpp"
#include "lab/run_folder.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;

// One field of a row; what separates fields may be in it.
std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

// One seed, in a process of its own. Returns the exit code.
int run_seed(const LabFiles& labs, std::int64_t seed, const std::filesystem::path& directory,
             hal::StopRequest& stop) try {
  JointRun run(read_labs(labs, seed), directory);
  const nlohmann::json result = run.run(stop, nullptr);
  if (run.finished()) return 0;
  fmt::print(stderr, "arkmesh: run of {} ended early: {}\n", run.names(), result.at("ended").get<std::string>());
  return 1;
} catch (const hal::ConfigError& e) {
  fmt::print(stderr, "arkmesh: seed {}: {}\n", seed, e.what());
  return 2;
} catch (const std::exception& e) {
  fmt::print(stderr, "arkmesh: seed {}: {}\n", seed, e.what());
  return 1;
}

}  // namespace

std::vector<hal::Config> read_labs(const LabFiles& labs, std::int64_t seed) {
  // "shark:key=value" is for lab shark alone
  std::vector<std::string> overrides, own, names;
  for (const std::string& set : labs.sets) (set.find(':') < set.find('=') ? own : overrides).push_back(set);
  if (seed >= 0) overrides.push_back(fmt::format("run.seed={}", seed));
  for (const std::string& file : labs.files)
    names.push_back(
        hal::Config::from_file(file, overrides).root().section("lab").get("name", std::string(), {.required = true}));
  for (const std::string& set : own)
    if (const std::string lab = set.substr(0, set.find(':')); std::ranges::find(names, lab) == names.end())
      throw hal::ConfigError(
          fmt::format("--set {}: there is no lab {} here; the labs are {}", set, lab, fmt::join(names, ", ")));
  if (std::none_of(overrides.begin(), overrides.end(),
                   [](const std::string& s) { return s.starts_with("shared.labs="); }))
    overrides.push_back(fmt::format("shared.labs=[\"{}\"]", fmt::join(names, "\",\"")));
  std::vector<hal::Config> configs;
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::vector<std::string> all = overrides;
    for (const std::string& set : own)
      if (set.starts_with(names[i] + ":")) all.push_back(set);
    configs.push_back(hal::Config::from_file(labs.files[i], all));
  }
  return configs;
}

Batch::Batch(LabFiles labs, std::int64_t first, std::int64_t last, int jobs, const std::filesystem::path& directory,
             bool force)
    : labs_(std::move(labs)),
      first_(first),
      last_(last),
      next_(first),
      jobs_(static_cast<std::size_t>(jobs)),
      directory_(directory) {
  read_labs(labs_, first);
  lab::claim_run_folder(directory_, force);
}

std::filesystem::path Batch::folder(std::int64_t seed) const {
  return directory_ / fmt::format("seed-{}", seed);
}

void Batch::start(std::int64_t seed, hal::StopRequest& stop) {
  const pid_t pid = ::fork();
  if (pid < 0) throw std::runtime_error("cannot start another process for the next seed; use fewer --jobs");
  if (pid == 0) {
    const int code = run_seed(labs_, seed, folder(seed), stop);
    std::fflush(nullptr);
    ::_exit(code);
  }
  running_[pid] = seed;
}

std::optional<Batch::Ended> Batch::next(hal::StopRequest& stop) {
  for (;;) {
    for (; next_ <= last_ && running_.size() < jobs_ && !stop.stopped(); ++next_) start(next_, stop);
    if (running_.empty()) return {};
    int status = 0;
    const auto ended = running_.find(::wait(&status));
    if (ended == running_.end()) continue;
    const Ended result{ended->second, WIFEXITED(status) && WEXITSTATUS(status) == 0};
    running_.erase(ended);
    return result;
  }
}

void Batch::save_table() const {
  std::map<std::int64_t, nlohmann::json> results;
  std::set<std::string> counts;  // of any seed
  for (std::int64_t seed = first_; seed <= last_; ++seed) {
    std::ifstream in(folder(seed) / "result.json");
    if (!in) continue;
    nlohmann::json result = nlohmann::json::parse(in, nullptr, false);
    if (result.is_discarded()) continue;
    for (const auto& [name, n] : result.at("counts").items()) counts.insert(name);
    results.emplace(seed, std::move(result));
  }
  // who looks meanwhile finds a whole table
  const fs::path unfinished = table().string() + ".part";
  std::ofstream out(unfinished);
  out << "seed,ended,final_hash";
  for (const std::string& name : counts) out << ',' << name;
  out << '\n';
  for (const auto& [seed, result] : results) {
    out << seed << ',' << csv_text(result.at("ended").get<std::string>()) << ','
        << result.at("final_hash").get<std::string>();
    for (const std::string& name : counts) out << ',' << result.at("counts").value(name, std::uint64_t{0});
    out << '\n';
  }
  if (!out.flush()) throw std::runtime_error(fmt::format("{}: cannot be written; is the disk full?", table().string()));
  fs::rename(unfinished, table());
}

}  // namespace arkmesh::app
