// Runs the labs of some files in one process with the network and the gate that are asked for, and prints one line of
// JSON. For tests/figures/exchange_modes.
//   exchange_runs FILE... --seed N [--free] [--delay-ms N] [--cut-every-s N --cut-s N] [--set key=value]...
// Free: every arena keeps real time by the steps of the run, a millisecond each, and waits for nobody, so delays and
// cuts are exact, the run is faster than life, and the same seed gives the same line.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lab/result.hpp"
#include "tests/support/labs/stepped_labs.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;

namespace {

struct Options {
  std::vector<std::string> files, sets;
  std::uint64_t seed = 1;
  bool free = false;
  std::uint32_t delay_ms = 0;
  double cut_every_s = 0, cut_s = 0;
};

Options read(int argc, char** argv) {
  Options o;
  CLI::App app("Labs in one process, with a network that is late or cut.");
  app.add_option("files", o.files, "configuration files of the labs")->required()->check(CLI::ExistingFile);
  app.add_option("--seed", o.seed);
  app.add_flag("--free", o.free, "arenas keep real time and wait for nobody");
  app.add_option("--delay-ms", o.delay_ms, "of every message, each way");
  app.add_option("--cut-every-s", o.cut_every_s, "the links are cut once in so many seconds");
  app.add_option("--cut-s", o.cut_s, "for so long");
  app.add_option("--set", o.sets, "key=value, for all labs")->take_all();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::exit(app.exit(error));
  }
  return o;
}

std::vector<hal::Config> configs(const Options& o) {
  std::vector<std::string> overrides = {"recorder.log=false", "run.seed=" + std::to_string(o.seed)};
  if (o.free)
    overrides.insert(overrides.end(), {"arena.use=stepped", "gate.on_peer_lost=go_on", "safety.pause_after_s=0"});
  overrides.insert(overrides.end(), o.sets.begin(), o.sets.end());
  std::vector<hal::Config> all;
  for (const std::string& file : o.files) all.push_back(hal::Config::from_file(file, overrides));
  return all;
}

void set_up(app::JointRun& run, bool up) {
  for (std::size_t a = 0; a < run.size(); ++a)
    for (std::size_t b = a + 1; b < run.size(); ++b) run.network().set_up(run.lab(a).name(), run.lab(b).name(), up);
}

nlohmann::json go(const Options& o) {
  const tests::TemporaryFolder folder;
  app::JointRun run(configs(o), folder.path());
  for (std::size_t a = 0; a < run.size(); ++a)
    for (std::size_t b = a + 1; b < run.size(); ++b)
      run.network().impair(run.lab(a).name(), run.lab(b).name(), {.delay_steps = o.delay_ms});
  const auto every = static_cast<std::uint64_t>(o.cut_every_s * 1000), cut = static_cast<std::uint64_t>(o.cut_s * 1000);
  while (tests::step(run)) {
    if (every == 0) continue;
    const std::uint64_t phase = run.steps() % every;
    if (run.steps() > every && phase == 0) set_up(run, false);
    if (phase == cut) set_up(run, true);
  }
  nlohmann::json out;
  for (std::size_t i = 0; i < run.size(); ++i) {
    const lab::Runner& lab = run.lab(i).runner();
    nlohmann::json& one = out["labs"][run.lab(i).name()];
    one = {{"ended", lab.reason().empty() ? std::string(lab.outcome()) : lab.reason()},
           {"gate", lab.strict() ? "strict" : "free"},
           {"exchange", lab.exchange_figures()},
           {"is_owner", lab.lab().is_owner()}};
    for (const auto& [name, n] : lab.lab().counts().all()) one["counts"][name] = n;
  }
  const lab::Runner& first = run.lab(0).runner();
  out["finished"] = run.finished();
  out["seconds"] = static_cast<double>((first.config().period * first.period()).count()) * 1e-6;
  out["final_hash"] = lab::hash_text(first.final_hash());
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = read(argc, argv);
  try {
    tests::add_stepped_arena();
    const nlohmann::json out = go(options);
    std::puts(out.dump().c_str());
    return out["finished"].get<bool>() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "exchange_runs: %s\n", error.what());
    return 2;
  }
}
