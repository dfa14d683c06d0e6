#include "app/configured_lab.hpp"

#include <fmt/format.h>

#include <random>
#include <utility>

#include "app/arenas.hpp"
#include "app/scenarios.hpp"
#include "hal/bus_config.hpp"
#include "hal/loop_time.hpp"
#include "hal/messages.hpp"

namespace arkmesh::app {
namespace {

std::unique_ptr<lab::Scenario> make_scenario(const hal::Section& root, const lab::RunConfig& run) {
  std::string known;
  std::unique_ptr<lab::Scenario> scenario;
  for (const CatalogueEntry& entry : catalogue()) {
    if (entry.name == run.scenario)
      scenario = entry.make(root.section("scenario").section(run.scenario), run.labs);
    else
      root.section("scenario").leave_alone(entry.name);
    known += (known.empty() ? "" : ", ") + entry.name;
  }
  if (scenario) return scenario;
  root.section("run").refuse("scenario", fmt::format("is none of: {}", known));
}

// 64 random bits, never 0.
std::uint64_t random_run_id() {
  std::random_device device;
  const std::uint64_t run_id = static_cast<std::uint64_t>(device()) << 32 | device();
  return run_id == 0 ? 1 : run_id;
}

}  // namespace

ConfiguredLab::ConfiguredLab(hal::Config config, const std::filesystem::path& directory, hal::EventLoop& loop)
    : loop_(loop),
      config_(std::move(config)),
      run_config_(config_.root().read<lab::RunConfig>()),
      run_id_(random_run_id()),
      private_bus_("memq://") {
  const hal::Section root = config_.root();
  bus_url_ = root.section("bus").read<hal::BusConfig>().url;
  gateway_config_ = gateway::read_gateway_config(root.section("gateway"), run_config_.lab, run_config_.labs);
  const auto recorder = root.section("recorder").read<lab::RecorderConfig>();
  scenario_ = make_scenario(root, run_config_);
  arena_ = make_arena(config_, run_config_, private_bus_, loop, directory);
  folder_ = std::make_unique<lab::RunFolder>(directory, config_.effective(directory), recorder.options());
  runner_ = std::make_unique<lab::Runner>(run_config_, lab::shared_settings(config_), *arena_, *scenario_, private_bus_,
                                          folder_->recorder(), run_id_);
}

// Robots do not go on when a run ends by an exception.
ConfiguredLab::~ConfiguredLab() {
  try {
    if (runner_) runner_->fail("the lab was ended");
    hal::LoopTime time(loop_);
    hal::end(*arena_, time);
  } catch (const std::exception&) {
    // the arena is lost
  }
}

std::unique_ptr<hal::Tap> ConfiguredLab::join(hal::Bus& public_bus) {
  runner_->count(public_bus);
  return std::make_unique<hal::Tap>(
      private_bus_, public_bus,
      std::vector<std::string>{"[^/]+/world", "[^/]+/status", hal::channel::peers, lab::ArenaPort::operator_channel});
}

}  // namespace arkmesh::app
