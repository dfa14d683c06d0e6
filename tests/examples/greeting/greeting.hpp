// The smallest scenario that listens: greets every robot at each boundary, and counts what robots answer. It is over
// when all labs have enough answers.
#pragma once

#include <cstdint>
#include <span>

#include "app/scenarios.hpp"
#include "lab/scenario.hpp"

namespace arkmesh::examples::greeting {

class Greeting final : public lab::Scenario {
 public:
  explicit Greeting(std::int64_t enough) : enough_(enough) {}

  void begin(lab::Lab& lab) override;
  void on_poses(lab::Lab&, const hal::PoseFrame&) override {}
  void on_heard(lab::Lab& lab, std::span<const hal::FromRobot> messages) override;
  void on_period(lab::Lab& lab) override;
  bool finished(const lab::Lab& lab) const override;

 private:
  std::int64_t enough_;
  std::int64_t answers_ = 0;
};

// Reads scenario.greeting.answers, of each lab (10, 1..1000000). Counts `greetings` and `answers`, and writes
// answers.csv.
app::CatalogueEntry greeting();

}  // namespace arkmesh::examples::greeting
