// arkmesh with scenarios that fail when they are told to: at the first boundary at which a file with the lab's name is
// in the folder ARKMESH_FAIL_IN. For tests/campaign/campaign; otherwise this program is arkmesh-testbed.
#include <cstdlib>
#include <filesystem>
#include <memory>
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

}  // namespace

int main(int argc, char** argv) {
  if (const char* folder = std::getenv("ARKMESH_FAIL_IN"))
    for (app::CatalogueEntry& entry : app::catalogue())
      entry.make = [make = entry.make, folder = std::string(folder)](
                       const hal::Section& settings,
                       const std::vector<std::string>& labs) -> std::unique_ptr<lab::Scenario> {
        return std::make_unique<Failing>(make(settings, labs), folder);
      };
  return cli::main(argc, argv, {});
}
