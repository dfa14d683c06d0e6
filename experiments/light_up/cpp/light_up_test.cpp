// The scenario in two labs without arenas: what it tells which robots.
#include "scenarios/light_up/light_up.hpp"

#include <cstdio>
#include <memory>
#include <string>

#include "lab/testing/lab_double.hpp"

using namespace arkmesh;
using namespace arkmesh::scenarios::light_up;

namespace {

int failures = 0;

void expect(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "it does not hold that %s\n", what);
  ++failures;
}

}  // namespace

int main() {
  // Lab b is seen at scale 2: its robots 4 and 6 cm from the centre are 8 and 12 cm from that of lab a.
  lab::WorldDouble world({{"a", 1.0, {}}, {"b", 0.5, {.scale = 2}}}, "a");
  world.begin([](const std::string&) { return std::make_unique<LightUp>(Settings{.reach_m = 0.10}); });
  world["a"].frame({.stamp = hal::LabTime(100'000), .number = 1, .robots = {{.robot = 0}}});
  world.boundary();
  world["b"].frame({.stamp = world.now() + hal::LabTime(100'000),
                    .number = 1,
                    .robots = {{.robot = 1, .pose = {0.04, 0, 0}}, {.robot = 2, .pose = {0, 0.06, 0}}}});
  const auto& said = world["b"].said;
  expect(said.size() == 1 && said[0].robot == 1 && said[0].kind == LightUp::lit,
         "only the near robot is told to be lit");
  expect(world["a"].said.empty(), "robots of the owner are told nothing");
  return failures == 0 ? 0 : 1;
}
