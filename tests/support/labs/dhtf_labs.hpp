// The DHTF labs of experiments/dhtf in one process, with overrides, for tests of whole labs.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "app/joint_run.hpp"
#include "tests/support/processes/process.hpp"

namespace arkmesh::tests {

inline std::filesystem::path experiments() {
  return std::filesystem::path(ARKMESH_SOURCE_DIR) / "experiments";
}

struct DhtfLabs {
  std::vector<std::string> labs = {"shark", "roark"};
  std::vector<std::string> overrides;  // on top of the defaults below
};

inline std::vector<hal::Config> dhtf_configs(const DhtfLabs& options) {
  std::string names;
  for (const std::string& lab : options.labs) names += (names.empty() ? "\"" : ",\"") + lab + "\"";
  std::vector<std::string> overrides = {"shared.labs=[" + names + "]", "recorder.log=false", "run.duration_s=120"};
  overrides.insert(overrides.end(), options.overrides.begin(), options.overrides.end());
  std::vector<hal::Config> configs;
  for (const std::string& lab : options.labs)
    configs.push_back(hal::Config::from_file(experiments() / "dhtf" / (lab + ".toml"), overrides));
  return configs;
}

// What a run of whole labs gave.
struct Outcome {
  bool finished = false;
  std::uint64_t hash = 0, completed = 0, steps = 0;
  hal::Counters drops;  // of all labs
  std::string reason;   // of the first lab that failed
};

// `each_step` may disturb the run; it is called after every step.
inline Outcome run_labs(const DhtfLabs& options, const std::function<void(app::JointRun&)>& each_step = {}) {
  const TemporaryFolder folder;
  app::JointRun run(dhtf_configs(options), folder.path());
  while (run.step())
    if (each_step) each_step(run);
  Outcome out;
  out.finished = run.finished();
  out.steps = run.steps();
  for (std::size_t i = 0; i < run.size(); ++i) {
    const lab::Runner& lab = run.lab(i).runner();
    out.drops.merge(lab.drops());
    if (!lab.finished() && out.reason.empty()) out.reason = lab.reason();
  }
  out.hash = run.lab(0).runner().final_hash();
  out.completed = run.lab(0).runner().lab().counts()["completed"];
  return out;
}

}  // namespace arkmesh::tests
