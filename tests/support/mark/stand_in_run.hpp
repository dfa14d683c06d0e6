// A lab of arkmesh and one that stands in for a scripted original, in one process and without wall time.
#pragma once

#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "app/joint_run.hpp"
#include "mark/stand_in.hpp"
#include "tests/support/labs/dhtf_configs.hpp"
#include "tests/support/labs/stepped_labs.hpp"
#include "tests/support/mark/scripted_link.hpp"
#include "tests/support/processes/process.hpp"

namespace arkmesh::tests {

class StandInRun {
 public:
  // `folder` of experiments/mark; `other`: the lab of arkmesh in it.
  StandInRun(mark::Role role, const std::string& folder, const std::string& other, ScriptedNetwork& network,
             const std::vector<std::string>& overrides, hal::WallTime& wall = hal::machine_time())
      : stand_in_(
            role,
            [&network](hal::EventLoop&, const mark::Settings&, mark::Role) {
              return std::make_unique<ScriptedLink>(network);
            },
            wall) {
    std::vector<std::string> all = {"recorder.log=false"};
    all.insert(all.end(), overrides.begin(), overrides.end());
    std::vector<hal::Config> configs;
    for (const std::string& lab : {std::string("argos"), other}) {
      if (lab == other) std::erase_if(all, [](const std::string& set) { return set.starts_with("mark."); });
      configs.push_back(hal::Config::from_file(experiments() / "mark" / folder / (lab + ".toml"), all));
    }
    run_ = std::make_unique<app::JointRun>(std::move(configs), folder_.path(), app::JointRun::Folder::must_be_empty,
                                           std::map<std::string, app::OwnParts*, std::less<>>{{"argos", &stand_in_}});
  }

  // A step. False: all labs have ended.
  bool step() { return tests::step(*run_); }
  // Lab time of a tick of the original that was there when it began.
  double seconds(std::uint64_t tick) {
    const auto& arena = dynamic_cast<const mark::OriginalArena&>(run_->lab("argos").arena());
    return 0.1 * (static_cast<double>(tick) - static_cast<double>(arena.original().ticks_before()));
  }
  app::JointRun& labs() { return *run_; }
  const lab::Runner& lab(const std::string& name) { return run_->lab(name).runner(); }
  mark::StandIn& stand_in() { return stand_in_; }
  std::filesystem::path folder(const std::string& lab) const { return folder_.path() / lab; }

 private:
  TemporaryFolder folder_;
  mark::StandIn stand_in_;
  std::unique_ptr<app::JointRun> run_;
};

}  // namespace arkmesh::tests
