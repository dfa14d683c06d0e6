// The DHTF labs of experiments/dhtf run in one process, for tests of whole labs.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/joint_run.hpp"
#include "tests/support/labs/dhtf_configs.hpp"
#include "tests/support/processes/process.hpp"

namespace arkmesh::tests {

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
