// One lab made from its configuration: arena, scenario, private bus, run folder and runner, in the order in which they
// need each other.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "gateway/config.hpp"
#include "hal/config.hpp"
#include "hal/tap.hpp"
#include "lab/run_folder.hpp"
#include "lab/runner.hpp"

namespace arkmesh::app {

class ConfiguredLab {
 public:
  // Reads every key, refuses unknown ones, writes `directory`/config.toml (the effective configuration) and opens the
  // recording. Throws ConfigError, or std::runtime_error when the directory cannot be written.
  ConfiguredLab(hal::Config config, const std::filesystem::path& directory);
  ~ConfiguredLab();

  // Copies the private bus to `public_bus` and lets in what a lab wants from others. The bus outlives the lab.
  void join(hal::Bus& public_bus);

  const std::string& name() const { return run_config_.lab; }
  lab::Runner& runner() { return *runner_; }
  const lab::Runner& runner() const { return *runner_; }
  hal::Arena& arena() { return *arena_; }
  const lab::RunConfig& config() const { return run_config_; }
  const gateway::GatewayConfig& gateway() const { return gateway_config_; }
  const std::string& bus_url() const { return bus_url_; }
  // The file that it was read from.
  std::string file() const { return config_.file().string(); }
  const lab::RunFolder& folder() const { return *folder_; }
  std::uint64_t run_id() const { return run_id_; }
  hal::Bus& bus() { return private_bus_; }

 private:
  hal::Config config_;
  lab::RunConfig run_config_;
  gateway::GatewayConfig gateway_config_;
  std::string bus_url_;
  std::uint64_t run_id_;
  hal::Bus private_bus_;
  std::unique_ptr<hal::Arena> arena_;
  std::unique_ptr<lab::Scenario> scenario_;
  std::unique_ptr<lab::RunFolder> folder_;
  std::unique_ptr<lab::Runner> runner_;
  std::unique_ptr<hal::Tap> tap_;
};

}  // namespace arkmesh::app
