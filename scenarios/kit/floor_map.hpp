// A floor of square tiles, each of a grey level or colour number: drawn from a seed with neighbours that are alike, or
// given.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/random.hpp"
#include "hal/types.hpp"
#include "lab/lab.hpp"

namespace arkmesh::scenarios::kit {

class FloorMap {
 public:
  struct Size {
    double width_m = 1, height_m = 1;  // around the origin
    int columns = 10, rows = 10;
  };
  // `tiles`: levels 0 to 255, row by row from the lower left corner. Throws std::invalid_argument with one sentence.
  FloorMap(const Size& size, std::vector<std::uint8_t> tiles);
  // Levels 0 .. shares.size()-1, of which each has its share of the tiles (the nearest whole number). `patch`: tiles
  // around each that go into what is drawn for it; 0: tiles are independent.
  static FloorMap drawn(const Size& size, const std::vector<double>& shares, int patch, hal::RandomStream& random);

  // The level under a place; outside that of the nearest tile.
  std::uint8_t at(const hal::Point& place) const;
  const std::vector<std::uint8_t>& tiles() const { return tiles_; }
  // In an arena that sees the floor's frame so; `full` is the level shown darkest. Tiles that are not square are not
  // shown.
  void draw(lab::Lab& lab, const hal::Projection& arena, std::uint8_t full) const;

 private:
  Size size_;
  std::vector<std::uint8_t> tiles_;
};

}  // namespace arkmesh::scenarios::kit
