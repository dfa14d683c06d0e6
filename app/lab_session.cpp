#include "app/lab_session.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <random>

#include "app/arenas.hpp"
#include "app/scenarios.hpp"
#include "hal/messages.hpp"

namespace arkmesh::app {
namespace {

std::unique_ptr<lab::Scenario> make_scenario(const hal::Section& root, const lab::RunConfig& run) {
  std::string known;
  std::unique_ptr<lab::Scenario> scenario;
  for (const app::CatalogueEntry& entry : app::catalogue()) {
    if (entry.name == run.scenario)
      scenario = entry.make(root.section("scenario").section(run.scenario), run.labs);
    else
      root.section("scenario").leave_alone(entry.name);
    known += (known.empty() ? "" : ", ") + entry.name;
  }
  if (scenario) return scenario;
  root.section("run").refuse("scenario", fmt::format("is none of: {}", known));
}

std::int64_t wall_utime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

std::uint64_t random_nonce() {
  std::random_device device;
  const std::uint64_t nonce = static_cast<std::uint64_t>(device()) << 32 | device();
  return nonce == 0 ? 1 : nonce;
}

std::filesystem::path default_run_directory() {
  return fmt::format("runs/{:%Y%m%d-%H%M%S}", fmt::localtime(std::time(nullptr)));
}

LabSession::LabSession(hal::Config config, const std::filesystem::path& directory)
    : config_(std::move(config)),
      directory_(directory),
      run_config_(lab::read_run_config(config_.root())),
      nonce_(random_nonce()),
      private_bus_("memq://") {
  const hal::Section root = config_.root();
  bus_url_ = root.section("bus").text("url", "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304");
  gateway_config_ = gateway::read_gateway_config(root.section("gateway"), run_config_.lab, run_config_.labs);
  const hal::Section recorder = root.section("recorder");
  const hal::Recorder::Options options{
      .log = recorder.flag("log", true),
      .keep_free_bytes = static_cast<std::uint64_t>(recorder.integer("keep_free_mib", 64, 0, 1 << 20)) << 20};
  scenario_ = make_scenario(root, run_config_);
  arena_ = make_arena(root, run_config_, private_bus_, directory_);
  config_.refuse_unknown();

  recorder_ = std::make_unique<hal::Recorder>(directory_, wall_utime(), options);
  std::ofstream(directory_ / "config.toml") << config_.effective();
  run_ = std::make_unique<lab::LabRun>(run_config_, lab::shared_settings(config_), *arena_, *scenario_, private_bus_,
                                       *recorder_, nonce_);
}

LabSession::~LabSession() = default;

void LabSession::join(hal::Bus& public_bus) {
  tap_ = std::make_unique<hal::Tap>(
      private_bus_, public_bus,
      std::vector<std::string>{"[^/]+/world", "[^/]+/status", hal::channel::peers, lab::LabRun::operator_channel});
}

}  // namespace arkmesh::app
