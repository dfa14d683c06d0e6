// Robots of an emulated testbed get their names: how soon, and with both protocols the same.
#include <doctest/doctest.h>

#include <string>

#include "tests/support/emulated/naming_trial.hpp"
#include "tests/support/processes/thorough.hpp"

using namespace arkmesh;

namespace {

// Twelve robots, some of which stand side by side.
tests::NamingTrial small_testbed(const std::string& identity, std::uint64_t seed) {
  return {.emulator = ARKMESH_SOURCE_DIR "/experiments/emulator/roark.toml",
          .sets = {"arena.width_m=0.3", "arena.height_m=0.3", "arena.ode.overhead_loss=0.1"},
          .identity = identity,
          .seed = seed,
          .within_s = 120};
}

}  // namespace

TEST_CASE("testbed: a hundred robots have their names in 15 s") {
  // From the moment when everything is switched on, robots walking until they are asked; no name is ever another
  // robot's, afterwards neither.
  for (const std::uint64_t seed : {1, 2}) {
    CAPTURE(seed);
    const tests::NamingResult result = tests::name_emulated(
        {.emulator = ARKMESH_SOURCE_DIR "/experiments/emulator/hundred.toml", .seed = seed, .then_s = 5});
    CHECK(result.robots == 100);
    CHECK(result.named_all_s > 0);
    CHECK(result.named_all_s < 15);
    CHECK(result.wrong == 0);
    CHECK(result.named >= 99);
  }
}

TEST_CASE("testbed: robots side by side, and messages that are lost" * doctest::skip(!arkmesh::tests::thorough())) {
  // On a crowded testbed where one copy in ten is not heard both protocols give every robot its own id.
  for (const std::string identity : {"spelled", "ark"}) {
    CAPTURE(identity);
    const tests::NamingResult result = tests::name_emulated(small_testbed(identity, 3));
    CHECK(result.named == 12);
    CHECK(result.named_all_s > 0);
    CHECK(result.wrong == 0);
  }
}
