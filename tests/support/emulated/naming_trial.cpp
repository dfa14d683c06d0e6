#include "tests/support/emulated/naming_trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <set>
#include <stdexcept>

#include "emulator/emulated_arena.hpp"
#include "emulator/emulator_record.hpp"
#include "hal/config/config.hpp"
#include "tests/support/processes/process.hpp"

namespace arkmesh::tests {
namespace {

constexpr double same_place_m = 0.0165;  // half a robot

// Compares names with the truth, picture by picture.
class Judge {
 public:
  Judge(const NamingTrial& trial, NamingResult& result) : trial_(trial), result_(result) {}
  void watch(emulator::Emulator& emulator) { emulator_ = &emulator; }

  void look(const testbed::Look& look) {
    const auto truth = emulator_->truth();
    named_now_.clear();
    for (const tracker::Track& track : look.tracker.tracks()) {
      if (!track.robot || track.doubtful) continue;
      const auto own =
          std::find_if(truth.begin(), truth.end(), [&](const auto& robot) { return robot.id == *track.robot; });
      const bool right = own != truth.end() && std::hypot(own->seen.pose.x_m - track.in_arena.x_m,
                                                          own->seen.pose.y_m - track.in_arena.y_m) < same_place_m;
      // a robot out of sight may have gone on
      if (!right && track.age.count() == 0) ++result_.wrong;
      if (right) named_now_.insert(*track.robot);
    }
    const double now_s = static_cast<double>(emulator_->now().count()) * 1e-6;
    for (const hal::RobotId robot : named_now_)
      if (ever_named_.insert(robot).second) result_.named_s.push_back(now_s);
    if (result_.named_all_s < 0 && named_now_.size() == truth.size()) result_.named_all_s = now_s;
    if (trial_.observer) trial_.observer(look, truth);
  }

  void finish() {
    const auto truth = emulator_->truth();
    result_.robots = static_cast<int>(truth.size());
    result_.named = static_cast<int>(named_now_.size());
    for (const auto& robot : truth)
      if (!named_now_.contains(robot.id)) result_.nameless.push_back(robot.seen.pose);
  }

 private:
  const NamingTrial& trial_;
  NamingResult& result_;
  emulator::Emulator* emulator_ = nullptr;
  std::set<hal::RobotId> named_now_, ever_named_;
};

}  // namespace

NamingResult name_emulated(const NamingTrial& trial) {
  const TemporaryFolder folder;
  const auto emulator_file = folder.path() / "emulator.toml", calibration = folder.path() / "emulator.yaml";
  std::string cameras, sides;
  {
    std::vector<std::string> sets = trial.sets;
    sets.push_back(fmt::format("emulator.seed={}", trial.seed));
    const hal::Config config = hal::Config::from_file(trial.emulator, sets);
    const emulator::Emulator emulator(config.root());
    emulator::write_calibration(emulator, calibration.string());
    std::ofstream(emulator_file) << config.effective();
    for (std::size_t k = 0; k < emulator.cameras(); ++k)
      cameras +=
          fmt::format("[[arena.kilobot.cameras]]\nsource = \"{}\"\ncalibration = \"{}\"\n", k, calibration.string());
    const hal::Section arena = config.root().section("arena");
    sides = fmt::format("robots = {}\nwidth_m = {}\nheight_m = {}\n", emulator.robots(), arena.get("width_m", 1.0),
                        arena.get("height_m", 1.0));
  }
  const hal::Config config = hal::Config::from_text(
      fmt::format("[arena]\n{}emulated.file = \"{}\"\n[arena.kilobot]\nidentity = \"{}\"\nnames_within_s = {}\n{}",
                  sides, emulator_file.string(), trial.identity, trial.within_s, cameras),
      "lab.toml", trial.lab);

  NamingResult result;
  Judge judge(trial, result);
  const auto arena = emulator::make_emulated_arena(config.root().section("arena"), "lab", trial.seed,
                                                   [&](const testbed::Look& look) { judge.look(look); });
  judge.watch(emulator::emulator_of(*arena));
  bool complete = true;
  try {
    hal::advance(*arena, hal::LabTime{0});
  } catch (const std::runtime_error& error) {
    if (std::string_view(error.what()).find("named") == std::string_view::npos) throw;
    complete = false;
  }
  if (complete && trial.then_s > 0) {
    arena->robots().command({hal::FleetCommand::Kind::run});
    for (hal::LabTime t = arena->info().frame_period; static_cast<double>(t.count()) * 1e-6 <= trial.then_s;
         t += arena->info().frame_period)
      hal::advance(*arena, t);
  }
  judge.finish();
  result.counters = arena->counters();
  return result;
}

}  // namespace arkmesh::tests
