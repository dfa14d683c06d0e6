// The virtual proximity sensor for walls.
#include "scenarios/wall_sensor.hpp"

#include <doctest/doctest.h>

#include <numbers>

using namespace arkmesh;
using scenarios::blocked_sectors;

namespace {

constexpr double degrees = std::numbers::pi / 180;

unsigned sectors(double x_m, double y_m, double heading_deg) {
  return blocked_sectors({x_m, y_m, heading_deg * degrees}, 1.0, 0.5, 0.066);
}

}  // namespace

TEST_CASE("wall sensor: sectors against one wall") {
  // Each heading against the east wall gives the sectors of the front half circle that point east.
  struct Row {
    double heading_deg;
    unsigned sectors;
  };
  for (const Row& row :
       {Row{0, 0b11111111}, Row{10, 0b01111111}, Row{-10, 0b11111110}, Row{22.5, 0b01111111}, Row{45, 0b00111111},
        Row{90, 0b00001111}, Row{-90, 0b11110000}, Row{135, 0b00000011}, Row{-135, 0b11000000}, Row{150, 0b00000001},
        Row{-150, 0b10000000}, Row{160, 0}, Row{180, 0}}) {
    INFO(row.heading_deg);
    CHECK(sectors(0.45, 0, row.heading_deg) == row.sectors);
    // The west wall, seen turned by half a circle, looks the same; so does each other wall by its own quarter.
    CHECK(sectors(-0.45, 0, row.heading_deg + 180) == row.sectors);
    CHECK(sectors(0, 0.2, row.heading_deg + 90) == row.sectors);
    CHECK(sectors(0, -0.2, row.heading_deg - 90) == row.sectors);
  }
}

TEST_CASE("wall sensor: zone and corners") {
  // Walls further than the zone are not seen, and the walls of a corner add up.
  CHECK(sectors(0.433, 0, 0) == 0);
  CHECK(sectors(0.435, 0, 0) == 0xff);
  CHECK(sectors(0, 0, 0) == 0);
  CHECK(sectors(0.45, 0.2, 90) == (0b11111111u));
  CHECK(sectors(0.45, 0.2, 0) == (0b11111111u));
  CHECK(sectors(0.45, 0.2, 180) == (sectors(0.45, 0, 180) | sectors(0, 0.2, 180)));
  CHECK(sectors(0.45, 0.2, 180) == 0b00001111u);
  CHECK(sectors(0.45, -0.2, 180) == 0b11110000u);
  // Facing out of the corner, to the south-west, nothing is blocked but what lies behind both shoulders.
  CHECK(sectors(0.45, 0.2, -135) == 0b11000011u);
}
