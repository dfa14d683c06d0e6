// One lab made from its configuration: arena, scenario, private bus, recorder and run, in the order in which they need
// each other.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "gateway/config.hpp"
#include "hal/config.hpp"
#include "hal/recorder.hpp"
#include "hal/tap.hpp"
#include "lab/lab_run.hpp"

namespace arkmesh::app {

class LabSession {
 public:
  // Reads every key, refuses unknown ones, writes `directory`/config.toml (the effective configuration) and opens the
  // recording. Throws ConfigError, or std::runtime_error when the directory cannot be written.
  LabSession(hal::Config config, const std::filesystem::path& directory);
  ~LabSession();

  // Copies the private bus to `public_bus` and lets in what a lab wants from others. The bus outlives the session.
  void join(hal::Bus& public_bus);

  lab::LabRun& run() { return *run_; }
  const lab::LabRun& run() const { return *run_; }
  hal::Arena& arena() { return *arena_; }
  const lab::RunConfig& config() const { return run_config_; }
  const gateway::GatewayConfig& gateway() const { return gateway_config_; }
  const std::string& bus_url() const { return bus_url_; }
  const std::filesystem::path& directory() const { return directory_; }
  std::uint64_t nonce() const { return nonce_; }
  hal::Bus& bus() { return private_bus_; }

 private:
  hal::Config config_;
  std::filesystem::path directory_;
  lab::RunConfig run_config_;
  gateway::GatewayConfig gateway_config_;
  std::string bus_url_;
  std::uint64_t nonce_;
  hal::Bus private_bus_;
  std::unique_ptr<hal::Arena> arena_;
  std::unique_ptr<lab::Scenario> scenario_;
  std::unique_ptr<hal::Recorder> recorder_;
  std::unique_ptr<lab::LabRun> run_;
  std::unique_ptr<hal::Tap> tap_;
};

// The default of --out: runs/DATE-TIME.
std::filesystem::path default_run_directory();
// 64 random bits, never 0.
std::uint64_t random_nonce();

}  // namespace arkmesh::app
