// What CRE's robots decide: probabilities, estimates, turns, and that north and south are alike in all of it.
#include <doctest/doctest.h>

#include <array>
#include <vector>

#include "scenarios/cre/controller/cre_decisions.h"

namespace {

using Estimates = std::array<std::uint16_t, 2>;

std::uint8_t swapped(std::uint8_t region) {
  return region == CRE_NORTH ? CRE_SOUTH : region == CRE_SOUTH ? CRE_NORTH : CRE_NONE;
}
Estimates swapped(Estimates e) {
  return {e[1], e[0]};
}

constexpr cre_rules paper{.commit = 50, .recruit = 200, .weight = 25, .abandon = 100};
constexpr std::uint16_t v_02 = 1500, v_07 = 5250;  // densities 0.2 and 0.7

std::uint8_t decide(const cre_rules& rules, std::uint8_t opinion, std::uint8_t heard, std::uint8_t tried, Estimates e,
                    std::uint32_t draw) {
  return cre_decide(&rules, opinion, heard, tried, e.data(), draw);
}

// The probability with which a decision ends in `result`: its bounds in the draw, found by bisection from below.
double probability(const cre_rules& rules, std::uint8_t opinion, std::uint8_t heard, std::uint8_t tried, Estimates e,
                   std::uint8_t result) {
  std::uint32_t n = 0;
  for (std::uint32_t draw = 0; draw < CRE_DRAWS; draw += 25)
    n += decide(rules, opinion, heard, tried, e, draw) == result;
  return n * 25.0 / static_cast<double>(CRE_DRAWS);
}

}  // namespace

TEST_CASE("cre decisions: north and south swapped give the swapped decision") {
  // Every decision of the programs, over all opinions, neighbours, tried regions, and draws from end to end, finds its
  // mirror image.
  std::array<int, 3> outcomes{};
  const std::vector<std::uint16_t> values = {0, 1, 74, 75, v_02, v_07, 7500, CRE_UNKNOWN};
  for (const cre_rules& rules : {paper, cre_rules{50, 200, 163, 0}, cre_rules{250, 250, 250, 3000}})
    for (std::uint8_t opinion : {CRE_NONE, CRE_NORTH, CRE_SOUTH})
      for (std::uint8_t heard : {CRE_NONE, CRE_NORTH, CRE_SOUTH})
        for (std::uint8_t tried : {CRE_NORTH, CRE_SOUTH})
          for (std::uint16_t north : values)
            for (std::uint16_t south : values)
              for (std::uint32_t draw = 0; draw < CRE_DRAWS; draw += 9973) {
                const std::uint8_t result = decide(rules, opinion, heard, tried, {north, south}, draw);
                ++outcomes[result];
                if (decide(rules, swapped(opinion), swapped(heard), swapped(tried), {south, north}, draw) !=
                    swapped(result))
                  FAIL("opinion ", int(opinion), " heard ", int(heard), " tried ", int(tried), " estimates ", north,
                       " ", south, " draw ", draw);
              }
  for (int n : outcomes) CHECK(n > 1000);
  CHECK(outcomes[CRE_NORTH] == outcomes[CRE_SOUTH]);

  // Estimates from readings.
  for (std::uint16_t north = 0; north < 32; ++north)
    for (std::uint16_t south = 0; south < 32; ++south)
      for (std::uint8_t ignore : {0, 1})
        for (std::uint16_t before : values) {
          Estimates one{before, v_02}, other{v_02, before};
          cre_take_densities(one.data(), static_cast<std::uint16_t>(north << 5 | south), 25, ignore);
          cre_take_densities(other.data(), static_cast<std::uint16_t>(south << 5 | north), 25, ignore);
          REQUIRE(swapped(one) == other);
        }

  // Turns of ground robots, in a mirror: a heading becomes its negative, left becomes right.
  for (int heading = 0; heading < CRE_TURN; ++heading) {
    const auto mirrored = static_cast<std::uint16_t>((CRE_TURN - heading) % CRE_TURN);
    const int turn = cre_turn_towards(CRE_NORTH, static_cast<std::uint16_t>(heading));
    REQUIRE(cre_turn_towards(CRE_SOUTH, mirrored) == -turn);
    REQUIRE(std::abs(turn) <= CRE_TURN / 2);
    REQUIRE((heading + turn + CRE_TURN) % CRE_TURN == CRE_TURN / 4);
  }
}

TEST_CASE("cre decisions: probabilities") {
  // The rates are those of the settings: h v, k v, a / v.
  const Estimates e{v_02, v_07};
  constexpr double close = 1e-4;
  const auto p = [&](std::uint8_t opinion, std::uint8_t heard, std::uint8_t tried, std::uint8_t result) {
    return probability(paper, opinion, heard, tried, e, result);
  };
  // Alone, an uncommitted robot commits to the region that it tries.
  CHECK(p(CRE_NONE, CRE_NONE, CRE_SOUTH, CRE_SOUTH) == doctest::Approx(0.2 * 0.7).epsilon(close));
  CHECK(p(CRE_NONE, CRE_NONE, CRE_NORTH, CRE_NORTH) == doctest::Approx(0.2 * 0.2).epsilon(close));
  CHECK(p(CRE_NONE, CRE_NONE, CRE_NORTH, CRE_SOUTH) == 0);
  // Recruited by a neighbour, it commits to that one's region, as its own estimate of it has it.
  CHECK(p(CRE_NONE, CRE_SOUTH, CRE_NORTH, CRE_SOUTH) == doctest::Approx(0.8 * 0.7).epsilon(close));
  CHECK(p(CRE_NONE, CRE_SOUTH, CRE_NORTH, CRE_NORTH) == doctest::Approx(0.2 * 0.2).epsilon(close));
  CHECK(p(CRE_NONE, CRE_SOUTH, CRE_SOUTH, CRE_SOUTH) == doctest::Approx(0.7).epsilon(close));
  // Committed, it gives up by itself, more often in the poorer region; inhibited by the other opinion only.
  CHECK(p(CRE_NORTH, CRE_NONE, CRE_SOUTH, CRE_NONE) == doctest::Approx(0.01 / 0.2).epsilon(1e-3));
  CHECK(p(CRE_SOUTH, CRE_NONE, CRE_NORTH, CRE_NONE) == doctest::Approx(0.01 / 0.7).epsilon(1e-3));
  CHECK(p(CRE_SOUTH, CRE_SOUTH, CRE_NORTH, CRE_NONE) == doctest::Approx(0.01 / 0.7).epsilon(1e-3));
  CHECK(p(CRE_SOUTH, CRE_NORTH, CRE_NORTH, CRE_NONE) == doctest::Approx(0.01 / 0.7 + 0.8 * 0.2).epsilon(1e-3));
  // A committed robot never changes sides without a time in between.
  CHECK(p(CRE_SOUTH, CRE_NORTH, CRE_NORTH, CRE_NORTH) == 0);
  // Where there is nothing, it gives up for sure; a preset without abandonment never does.
  CHECK(probability(paper, CRE_NORTH, CRE_NONE, CRE_NORTH, {75, v_07}, CRE_NONE) == 1);
  CHECK(probability(paper, CRE_NORTH, CRE_NONE, CRE_NORTH, {0, v_07}, CRE_NONE) == 1);
  CHECK(probability({50, 200, 25, 0}, CRE_NORTH, CRE_NONE, CRE_NORTH, {0, v_07}, CRE_NONE) == 0);
  // The largest rates stay within 32 bits.
  CHECK(probability({250, 250, 25, CRE_ABANDON_MAX}, CRE_NORTH, CRE_NONE, CRE_NORTH, {7500, 0}, CRE_NONE) ==
        doctest::Approx(0.3).epsilon(1e-3));
}

TEST_CASE("cre decisions: estimates") {
  // The first reading sets an estimate; each later one moves it by its weight, and it reaches every density from both
  // sides.
  CHECK(cre_estimate(CRE_UNKNOWN, CRE_NO_PLACE, 25) == CRE_UNKNOWN);
  CHECK(cre_estimate(CRE_UNKNOWN, 6, 25) == v_02);
  CHECK(cre_estimate(v_02, CRE_NO_PLACE, 25) == v_02);
  CHECK(cre_estimate(v_02, 21, 25) == v_02 + 375);
  CHECK(cre_estimate(v_02, 21, 250) == v_07);
  CHECK(cre_estimate(v_07, 0, 250) == 0);
  for (std::uint16_t start : {0, 7500})
    for (std::uint8_t reading = 0; reading <= CRE_FULL; ++reading) {
      std::uint16_t estimate = start;
      for (int i = 0; i < 200; ++i) estimate = cre_estimate(estimate, reading, 25);
      CHECK(std::abs(estimate - reading * CRE_ESTIMATE_PER_READING) < 6);
    }
  // A density of zero may be no reading.
  Estimates e{v_02, v_07};
  cre_take_densities(e.data(), 0, 25, 1);
  CHECK(e == Estimates{v_02, v_07});
  cre_take_densities(e.data(), 0, 25, 0);
  CHECK(e == Estimates{1350, 4725});
}
