// arkmesh with scenarios that fail when they are told to: at the first boundary at which a file with the lab's name is
// in the folder ARKMESH_FAIL_IN; and with one that tells robots what it is told by files there. For
// tests/campaign/campaign; otherwise this program is arkmesh-testbed.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "app/scenarios.hpp"
#include "cli/whole_program.hpp"
#include "lab/scenario.hpp"

namespace {

using namespace arkmesh;

class Failing final : public lab::Scenario {
 public:
  Failing(std::unique_ptr<lab::Scenario> scenario, std::filesystem::path folder)
      : scenario_(std::move(scenario)), folder_(std::move(folder)) {}

  void begin(lab::Lab& lab) override { scenario_->begin(lab); }
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override { scenario_->on_poses(lab, frame); }
  void on_heard(lab::Lab& lab, std::span<const hal::FromRobot> messages) override {
    scenario_->on_heard(lab, messages);
  }
  void on_period(lab::Lab& lab) override {
    if (std::filesystem::exists(folder_ / lab.name())) throw std::runtime_error("the scenario was told to fail");
    scenario_->on_period(lab);
  }
  bool finished(const lab::Lab& lab) const override { return scenario_->finished(lab); }

 private:
  std::unique_ptr<lab::Scenario> scenario_;
  std::filesystem::path folder_;
};

// As campaign_words.py has it in Python.
class Words final : public lab::Scenario {
 public:
  explicit Words(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void begin(lab::Lab& lab) override {
    if (std::filesystem::exists(folder_ / "parameters")) lab.parameters({20, {7, 7, 7, 7, 7, 7, 7, 7, 7}});
  }
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override {
    const bool second = std::filesystem::exists(folder_ / "word2");
    if (!second && !std::filesystem::exists(folder_ / "word1")) return;
    for (const hal::Observation& seen : frame.robots)
      lab.tell({.robot = seen.robot, .kind = static_cast<std::uint8_t>(second ? 2 : 1)}, seen.led);
  }
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}
  void on_period(lab::Lab&) override {}
  bool finished(const lab::Lab&) const override { return false; }

 private:
  std::filesystem::path folder_;
};

}  // namespace

int main(int argc, char** argv) {
  if (const char* folder = std::getenv("ARKMESH_FAIL_IN")) {
    app::catalogue().push_back(
        {.name = "words",
         .make = [folder](const hal::Section&,
                          const std::vector<std::string>&) { return std::make_unique<Words>(folder); },
         .kinds = 3});
    for (app::CatalogueEntry& entry : app::catalogue())
      entry.make = [make = entry.make, folder = std::string(folder)](
                       const hal::Section& settings,
                       const std::vector<std::string>& labs) -> std::unique_ptr<lab::Scenario> {
        return std::make_unique<Failing>(make(settings, labs), folder);
      };
  }
  return cli::main(argc, argv, {});
}
