// The sample of all keys, and what a run keeps of its configuration.
#include "app/config_keys.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "app/joint_run.hpp"
#include "gateway/config.hpp"
#include "hal/arenas/arena_config.hpp"
#include "lab/run_config.hpp"
#include "scenarios/dhtf/settings.hpp"
#include "sim_ode/settings.hpp"
#include "tests/support/labs/dhtf_configs.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;

namespace {

// Everything of a simulated DHTF lab but its robots.
void read_lab(const hal::Config& config) {
  const hal::Section root = config.root();
  const auto run = root.read<lab::RunConfig>();
  gateway::read_gateway_config(root.section("gateway"), run.lab, run.labs);
  root.section("bus").get("url", std::string());
  root.section("recorder").read<lab::RecorderConfig>();
  root.section("arena").get("use", std::string());
  hal::read_arena_config(root.section("arena"), 0.0165);
  sim_ode::read_settings(root.section("arena"));
  scenarios::dhtf::read_settings(root.section("scenario").section("dhtf"), run.labs);
  config.refuse_unknown();
}

}  // namespace

TEST_CASE("the sample is a lab that runs") {
  tests::TemporaryDirectory folder;
  const auto file = folder.write("sample.toml", hal::print_sample(app::all_keys()));
  std::vector<hal::Config> configs;
  configs.push_back(hal::Config::from_file(file, {"run.duration_s=20"}));
  app::JointRun run(std::move(configs), folder.path() / "run");
  while (run.step()) {
  }
  CHECK(run.finished());
  CHECK(run.lab("lab").name() == "lab");
}

TEST_CASE("a run's config.toml says the same from elsewhere") {
  // Moved with its folder; the shipped controller is found again, and what labs share has no places in it.
  tests::TemporaryDirectory folder;
  const auto shipped = tests::experiments() / "dhtf" / "shark.toml";
  const auto load = [](const std::filesystem::path& file) {
    hal::Config config = hal::Config::from_file(file);
    read_lab(config);
    return config;
  };
  const hal::Config first = load(shipped);
  const std::string written = first.effective(folder.path() / "run");
  CHECK(written.find("controller = \"arkmesh:scenarios/dhtf/controller/dhtf.c\"") != std::string::npos);
  const hal::Config again = load(folder.write("elsewhere/config.toml", written));
  CHECK(lab::shared_settings(again) == lab::shared_settings(first));
  const auto controller = [](const hal::Config& config) {
    return sim_ode::read_settings(config.root().section("arena")).controller.paths.at(0);
  };
  CHECK(controller(again) == controller(first));
}
