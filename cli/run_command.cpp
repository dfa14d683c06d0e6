// `arkmesh run`: several labs in one process, for one seed or a batch of seeds.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "app/joint_run.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "cli/progress.hpp"
#include "lab/result.hpp"

namespace arkmesh::cli {
namespace {

struct RunOptions {
  std::vector<std::string> files, sets;
  std::string seeds, out;
  std::int64_t seed = -1;
  int jobs = 1;
};

// `arkmesh run` joins exactly the labs whose files it is given, unless shared.labs is set on the command line.
std::vector<hal::Config> read_labs(const RunOptions& options, std::int64_t seed) {
  std::vector<std::string> overrides = options.sets;
  if (seed >= 0) overrides.push_back(fmt::format("run.seed={}", seed));
  if (std::none_of(overrides.begin(), overrides.end(),
                   [](const std::string& s) { return s.starts_with("shared.labs="); })) {
    std::vector<std::string> names;
    for (const std::string& file : options.files)
      names.push_back(
          fmt::format("\"{}\"", hal::Config::from_file(file, overrides).root().section("lab").required_text("name")));
    overrides.push_back(fmt::format("shared.labs=[{}]", fmt::join(names, ",")));
  }
  std::vector<hal::Config> configs;
  for (const std::string& file : options.files) configs.push_back(hal::Config::from_file(file, overrides));
  return configs;
}

// A row per period with every lab's hash, so that the first difference between two runs is found at once.
void join_hashes(const app::JointRun& run, const std::filesystem::path& directory) {
  std::ofstream out(directory / "hash.csv");
  std::vector<std::ifstream> in;
  out << "period";
  for (std::size_t i = 0; i < run.size(); ++i) {
    out << ',' << run.lab(i).config().lab;
    in.emplace_back(run.lab(i).directory() / "hash.csv");
    std::string header;
    std::getline(in.back(), header);
  }
  out << '\n';
  for (std::string row; !in.empty() && std::getline(in.front(), row);) {
    for (std::size_t i = 1; i < in.size(); ++i)
      if (std::string other; std::getline(in[i], other)) row += other.substr(other.find(','));
    out << row << '\n';
  }
}

// One seed. Returns the exit code.
int run_seed(const RunOptions& options, std::int64_t seed, const std::filesystem::path& directory, bool show) {
  app::JointRun run(read_labs(options, seed), directory);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < run.size(); ++i) names.push_back(run.lab(i).config().lab);
  Progress progress(fmt::format("{}", fmt::join(names, "+")));
  const double period_s = static_cast<double>(run.lab(0).config().period.count()) * 1e-6;
  const lab::LabRun& first = run.lab(0).run();
  const auto begun = std::chrono::steady_clock::now();
  while (run.step()) {
    if (operator_stops())
      for (std::size_t i = 0; i < run.size(); ++i) run.lab(i).run().stop("stopped by the operator");
    if (show && run.steps() % 64 == 0)
      progress.show(first.period(), first.last_period(), period_s, first.awaits_arena() ? first.state_text() : "");
  }
  progress.done();
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  const std::vector<nlohmann::json> results = run.results(wall_s);
  for (std::size_t i = 0; i < run.size(); ++i) lab::write_json(run.lab(i).directory() / "result.json", results[i]);
  nlohmann::json result = lab::joint_result(results);
  result["wall"] = {{"total_s", wall_s}, {"speed", wall_s > 0 ? result.at("duration_s").get<double>() / wall_s : 0}};
  join_hashes(run, directory);
  lab::write_json(directory / "result.json", result);
  if (!run.finished()) {
    fmt::print(stderr, "arkmesh: run of {} ended early: {}\n", fmt::join(names, "+"),
               result.at("ended").get<std::string>());
    return 1;
  }
  if (show) {
    fmt::print("{}, seed {}: {:.0f} s simulated in {:.1f} s ({:.0f}x), final hash {}\n", fmt::join(names, "+"),
               result.at("seed").get<std::uint64_t>(), result.at("duration_s").get<double>(), wall_s,
               result.at("wall").at("speed").get<double>(), result.at("final_hash").get<std::string>());
    for (const auto& [name, n] : result.at("counts").items()) fmt::print("  {}: {}\n", name, n.get<std::uint64_t>());
    fmt::print("  results in {}\n", directory.string());
  }
  return 0;
}

// Each seed in a process of its own, at most `jobs` at a time; then one table of all.
int run_batch(const RunOptions& options, std::int64_t first, std::int64_t last,
              const std::filesystem::path& directory) {
  read_labs(options, first);  // a wrong configuration is said once, before anything starts
  std::map<pid_t, std::int64_t> running;
  int failed = 0;
  std::int64_t done = 0;
  const auto reap = [&] {
    int status = 0;
    const pid_t pid = ::wait(&status);
    if (pid < 0) return;
    const bool good = WIFEXITED(status) && WEXITSTATUS(status) == 0;
    failed += good ? 0 : 1;
    fmt::print(stderr, "seed {} {}  ({}/{})\n", running[pid], good ? "done" : "failed", ++done, last - first + 1);
    running.erase(pid);
  };
  for (std::int64_t seed = first; seed <= last && !operator_stops(); ++seed) {
    while (static_cast<int>(running.size()) >= options.jobs) reap();
    const pid_t pid = ::fork();
    if (pid == 0) {
      int code = 1;
      try {
        code = run_seed(options, seed, directory / fmt::format("seed-{}", seed), false);
      } catch (const hal::ConfigError& e) {
        fmt::print(stderr, "arkmesh: seed {}: {}\n", seed, e.what());
        code = 2;
      } catch (const std::exception& e) {
        fmt::print(stderr, "arkmesh: seed {}: {}\n", seed, e.what());
      }
      std::fflush(nullptr);
      ::_exit(code);
    }
    if (pid < 0) throw std::runtime_error("cannot start another process for the next seed; use fewer --jobs");
    running[pid] = seed;
  }
  while (!running.empty()) reap();

  std::ofstream table(directory / "seeds.csv");
  std::string header;
  for (std::int64_t seed = first; seed <= last; ++seed) {
    std::ifstream in(directory / fmt::format("seed-{}", seed) / "result.json");
    if (!in) continue;
    const nlohmann::json result = nlohmann::json::parse(in, nullptr, false);
    if (result.is_discarded()) continue;
    if (header.empty()) {
      header = "seed,ended,final_hash,speed";
      for (const auto& [name, n] : result.at("counts").items()) header += "," + name;
      table << header << '\n';
    }
    table << fmt::format("{},{},{},{:.1f}", seed, result.at("ended").get<std::string>(),
                         result.at("final_hash").get<std::string>(), result.at("wall").at("speed").get<double>());
    for (const auto& [name, n] : result.at("counts").items()) table << ',' << n.get<std::uint64_t>();
    table << '\n';
  }
  fmt::print("{} runs, {} failed; table in {}\n", last - first + 1, failed, (directory / "seeds.csv").string());
  return failed == 0 && !operator_stops() ? 0 : 1;
}

std::pair<std::int64_t, std::int64_t> parse_seeds(const std::string& text) {
  std::int64_t first = -1, last = -1;
  int used = 0;
  if (std::sscanf(text.c_str(), "%ld..%ld%n", &first, &last, &used) != 2 || used != static_cast<int>(text.size()) ||
      first < 0 || last < first)
    throw hal::ConfigError(
        fmt::format("--seeds {}: must be FIRST..LAST with 0 <= FIRST <= LAST, for example 1..20", text));
  return {first, last};
}

int run(const RunOptions& options) {
  std::ignore = operator_stops();  // from now on
  const std::filesystem::path directory =
      options.out.empty() ? app::default_run_directory() : std::filesystem::path(options.out);
  if (options.seeds.empty()) {
    std::filesystem::create_directories(directory);
    return run_seed(options, options.seed, directory, true);
  }
  const auto [first, last] = parse_seeds(options.seeds);
  std::filesystem::create_directories(directory);
  return run_batch(options, first, last, directory);
}

}  // namespace

void add_run_command(CLI::App& app) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = add_command(app, "run");
  command->add_option("files", options->files, "A configuration file for each lab")
      ->required()
      ->check(CLI::ExistingFile);
  auto* seed = command->add_option("--seed", options->seed, "Seed of all labs (overrides run.seed)")
                   ->check(CLI::NonNegativeNumber);
  command->add_option("--seeds", options->seeds, "A batch, one run per seed: FIRST..LAST")->excludes(seed);
  command->add_option("--jobs", options->jobs, "How many runs of a batch at a time")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--out", options->out, "Folder for the results (default runs/DATE-TIME)");
  command->add_option("--set", options->sets, "Override a key of every lab: --set gate.slack=1")
      ->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh run experiments/dhtf/shark.toml experiments/dhtf/roark.toml --seed 7 --set "
      "run.duration_s=600\n"
      "The labs of the shared world are those given; shared.labs of the files is not used unless --set says so.");
  command->callback([options] {
    hand_over_cameras(options->files, options->sets);
    if (const int code = run(*options); code != 0) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
