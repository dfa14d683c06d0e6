// One lab made from its configuration: arena, scenario, private bus, run folder and runner, in the order in which they
// need each other.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/own_parts.hpp"
#include "app/trusted_signatures.hpp"
#include "gateway/config.hpp"
#include "hal/arenas/picture_board.hpp"
#include "hal/bus/bus_config.hpp"
#include "hal/bus/tap.hpp"
#include "hal/config/config.hpp"
#include "hal/event_loop.hpp"
#include "lab/operator/command_audit.hpp"
#include "lab/run_folder.hpp"
#include "lab/runner.hpp"
#include "scenarios/python/python_scenario.hpp"
#include "view/view_config.hpp"

namespace arkmesh::app {

class ConfiguredLab {
 public:
  // Reads every key, refuses unknown ones, and makes all but the run: nothing is written. `directory` is for the run;
  // `loop` is served while the lab ends, and outlives it. `own`: null for an arena and a scenario of the tables,
  // else it brings both. Throws ConfigError.
  ConfiguredLab(hal::Config config, std::filesystem::path directory, hal::EventLoop& loop, OwnParts* own = nullptr);
  ~ConfiguredLab();
  // Once, before anything else: opens the run folder and makes the runner. `worlds`: that of all labs of this process,
  // which together have thousands of periods a second and write their files 20 times at most; null: this lab is alone,
  // and each period is on the disk when the next one begins. Throws as RunFolder does.
  void open_run(std::shared_ptr<lab::WorldReader> worlds = nullptr);

  // While it lives the lab hears operators. The private bus is copied to the public one, what a lab wants from others
  // is let in, and that bus's counters are the run's, too; where labs of one process meet on their private buses there
  // is no other (`public_bus` is bus()). Bus and lab outlive it.
  class Membership {
   public:
    Membership(ConfiguredLab& lab, hal::Bus& public_bus);
    ~Membership() { runner_.count(nullptr); }
    Membership(const Membership&) = delete;
    Membership& operator=(const Membership&) = delete;

   private:
    lab::Runner& runner_;
    std::optional<hal::Tap> tap_;
    std::unique_ptr<hal::Bus::Subscription> commands_;  // of operators; the lab copies none to its private bus
  };

  const std::string& name() const { return run_config_.lab; }
  lab::Runner& runner() { return *runner_; }
  const lab::Runner& runner() const { return *runner_; }
  hal::Arena& arena() { return *arena_; }
  const hal::Arena& arena() const { return *arena_; }
  const lab::RunConfig& config() const { return run_config_; }
  const gateway::GatewayConfig& gateway() const { return gateway_config_; }
  const hal::BusConfig& bus_config() const { return bus_config_; }
  // The file that it was read from.
  std::string file() const { return config_.file().string(); }
  const lab::RecorderConfig& recorder() const { return recorder_config_; }
  // The files that it was made from: configurations, and the program of simulated robots.
  std::vector<std::filesystem::path> inputs() const;
  const lab::RunFolder& folder() const { return *folder_; }
  // The run's table of commands, for what its page refuses before the runner hears of it. After open_run().
  lab::CommandAudit command_audit() { return {folder_->recorder(), arena_->clock()}; }
  const nlohmann::json& facts() const { return facts_; }
  std::uint64_t run_id() const { return run_id_; }
  hal::Bus& bus() { return private_bus_; }
  hal::PictureBoard& pictures() { return pictures_; }
  const view::ViewConfig& view() const { return view_config_; }
  bool has_run() const { return runner_ != nullptr; }  // open_run() was called

 private:
  void make_parts(OwnParts* own);
  std::map<std::string, std::string, std::less<>> settings() const;
  // What simulated robots run, also those of an emulated testbed; empty when there are none.
  std::vector<std::filesystem::path> robots_programs() const;
  hal::Config::Kept kept_files() const;

  hal::EventLoop& loop_;
  hal::Config config_;
  std::filesystem::path directory_;
  lab::RunConfig run_config_;
  gateway::GatewayConfig gateway_config_;
  hal::BusConfig bus_config_;
  view::ViewConfig view_config_;
  lab::RecorderConfig recorder_config_;
  nlohmann::json facts_;  // of the run's result
  std::uint64_t run_id_;
  TrustedSignatures signatures_;
  hal::Bus private_bus_;
  hal::PictureBoard pictures_;
  bool own_parts_ = false;
  std::unique_ptr<hal::Arena> arena_;
  std::unique_ptr<lab::Scenario> scenario_;
  scenarios::python::PythonScenario* python_ = nullptr;  // the scenario, if it is in Python
  std::unique_ptr<lab::RunFolder> folder_;
  std::unique_ptr<lab::Runner> runner_;
};

}  // namespace arkmesh::app
