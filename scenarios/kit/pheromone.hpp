// A quantity on a grid, such as pheromone: laid by robots, evaporating, spreading, carried by wind; and what a robot
// smells of it. Computed alike everywhere from the same calls, so that labs which make the same calls hold the same
// field.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/types.hpp"
#include "lab/lab.hpp"

namespace arkmesh::scenarios::kit {

class Pheromone {
 public:
  struct Settings {
    double width_m = 1, height_m = 1;  // of the field, around the origin of its frame
    double cell_m = 0.01;
    double half_life_s = 0;                 // after which half is left; 0: it does not decay so
    double linear_per_s = 0;                // and so much less each second, down to nothing
    double diffusion_m2_s = 0;              // D of Fick's law; nothing leaves the field
    double wind_x_m_s = 0, wind_y_m_s = 0;  // what reaches the edge stays there
    double cap = 1e9;                       // no cell has more
    double cut_off = 0;                     // less is nothing
  };
  static constexpr std::size_t max_cells = 1 << 20;

  // Throws std::invalid_argument with one sentence for settings that make no sense or need more than max_cells.
  explicit Pheromone(const Settings& settings);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  // Row by row from the lower left corner. -1: the place is outside.
  int cell_at(const hal::Point& place) const;
  hal::Point centre_of(int cell) const;
  double in_cell(int cell) const { return cells_[static_cast<std::size_t>(cell)]; }
  const std::vector<double>& cells() const { return cells_; }

  // Adds to a cell, up to the cap; outside there is none.
  void lay(const hal::Point& place, double amount) { lay_in(cell_at(place), amount); }
  void lay_in(int cell, double amount);
  // Lets time pass: decay, then spreading and wind, in as many steps as they need, then what is below the cut-off is
  // gone. Wind carries along and, as steps are whole cells' shares, also spreads like a diffusion of up to 3/8 of its
  // speed times a cell's side.
  void pass(double seconds);
  // So many steps. Throws std::invalid_argument where they would take too long.
  double steps(double seconds) const;

  // In the place's cell; 0 outside.
  double at(const hal::Point& place) const;
  // Per metre, from the cells on either side; at an edge from one.
  hal::Point gradient(const hal::Point& place) const;
  // Zones in front of a robot, as bits: bit 0 the last, which is rightmost. A zone's bit is set when a cell of at least
  // `least` has its centre there. Zones share `opening_rad` equally around the heading; `radius_m` from the robot.
  std::uint32_t zones(const hal::Pose& robot, int count, double opening_rad, double radius_m, double least) const;

  // In an arena that sees the field's frame so; what is `full` is drawn darkest.
  void draw(lab::Lab& lab, const hal::Projection& arena, double full,
            hal::Colour colour = hal::Colour::pheromone) const;

 private:
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }
  void decay(double seconds);
  void spread(double seconds);

  Settings settings_;
  int columns_, rows_;
  std::vector<double> cells_, next_;
};

}  // namespace arkmesh::scenarios::kit
