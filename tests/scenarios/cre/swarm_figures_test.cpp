// What a run of CRE is judged by: consensus, who followed, who waited in the middle.
#include "scenarios/cre/swarm_figures.hpp"

#include <doctest/doctest.h>

using namespace arkmesh;
using namespace std::chrono_literals;
namespace cre = scenarios::cre;

namespace {

// 20 flying robots and 100 ground robots.
cre::Swarms swarms_at(hal::LabTime time, int north, int south, int ground_south, int middle = 25) {
  return {.time = time,
          .uncommitted = 20 - north - south,
          .committed = {north, south},
          .ground = 100,
          .ground_south = ground_south,
          .ground_middle = middle,
          .bands = {}};
}

hal::Counters told(const cre::SwarmFigures& figures) {
  hal::Counters counts;
  figures.tell(counts);
  return counts;
}

}  // namespace

TEST_CASE("cre figures: where ground robots are") {
  // Ten bands from south to north, the border, and the middle quarter; robots pushed over the edge count at the edge.
  cre::Swarms swarms;
  for (double y : {-1.01, -0.99, -0.81, -0.79, -0.24, -0.01, 0.01, 0.24, 0.26, 0.99, 1.0, 1.01})
    swarms.add_ground({.x_m = 0, .y_m = y}, 2);
  CHECK(swarms.bands == std::array{3, 1, 0, 1, 1, 1, 2, 0, 0, 3});
  CHECK(swarms.ground == 12);
  CHECK(swarms.ground_south == 6);
  CHECK(swarms.ground_middle == 4);
}

TEST_CASE("cre figures: the first consensus") {
  // It is the first time that 18 of 20 are committed to one region; what comes later does not move it.
  cre::SwarmFigures figures(0.9, 60s);
  figures.add(swarms_at(2s, 2, 17, 50));
  CHECK(told(figures)["consensus.south"] == 0);
  CHECK(told(figures).all().count("consensus.ms") == 0);
  figures.add(swarms_at(4s, 1, 18, 50));
  figures.add(swarms_at(6s, 1, 17, 50));
  figures.add(swarms_at(8s, 20, 0, 50));
  figures.add(swarms_at(10s, 0, 20, 50));
  const hal::Counters counts = told(figures);
  CHECK(counts["consensus.ms"] == 4000);
  CHECK(counts["consensus.south"] == 1);
  CHECK(counts["consensus.north"] == 0);
  CHECK(counts["consensus.periods"] == 4);
  CHECK(counts["consensus.held"] == 2);
  cre::SwarmFigures other(0.9, 60s);
  other.add(swarms_at(2s, 18, 2, 50));
  CHECK(told(other)["consensus.north"] == 1);
}

TEST_CASE("cre figures: who followed, and who waited in the middle") {
  // Ground robots have followed when 90 % are in the region of the consensus, whichever it is; the peak in the middle
  // is of the time before it.
  for (bool to_south : {true, false}) {
    const auto at = [&](hal::LabTime time, int for_it, int there, int middle) {
      return to_south ? swarms_at(time, 0, for_it, there, middle) : swarms_at(time, for_it, 0, 100 - there, middle);
    };
    cre::SwarmFigures figures(0.9, 60s);
    figures.add(at(2s, 5, 95, 30));  // many are there by chance
    figures.add(at(4s, 10, 60, 55));
    figures.add(at(6s, 18, 60, 40));
    figures.add(at(8s, 20, 89, 90));
    CHECK(told(figures).all().count("ground.followed_ms") == 0);
    figures.add(at(10s, 20, 90, 90));
    figures.add(at(12s, 20, 99, 90));
    CHECK(told(figures)["ground.followed_ms"] == 10'000);
    CHECK(told(figures)["ground.middle_peak_ppm"] == 550'000);
  }
}

TEST_CASE("cre figures: means over the last minute") {
  // What is older than a minute does not count.
  cre::SwarmFigures figures(0.9, 60s);
  for (int k = 0; k <= 100; ++k) figures.add(swarms_at(k * 2s, 0, 10, 0));
  for (int k = 101; k <= 115; ++k) figures.add(swarms_at(k * 2s, 5, 15, 100));
  CHECK(told(figures)["ground.south_ppm"] == 500'000);
  CHECK(told(figures)["flying.south_ppm"] == 625'000);
  CHECK(told(figures)["flying.north_ppm"] == 125'000);
  for (int k = 116; k <= 130; ++k) figures.add(swarms_at(k * 2s, 5, 15, 100));
  CHECK(told(figures)["ground.south_ppm"] == 1'000'000);
}

TEST_CASE("cre figures: no robots") {
  // Swarms that nobody sees have no consensus, and nothing is divided by zero.
  cre::SwarmFigures figures(0.9, 60s);
  figures.add({.time = 2s});
  CHECK(told(figures)["consensus.south"] == 0);
  CHECK(told(figures)["ground.south_ppm"] == 0);
}
