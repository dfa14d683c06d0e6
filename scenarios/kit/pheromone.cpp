// Explicit steps, as large as stability allows: D dt / cell^2 at most 1/8 in each direction, wind a quarter of a cell,
// so that no cell gives more than it has.
#include "scenarios/kit/pheromone.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "hal/fixed_math.hpp"

namespace arkmesh::scenarios::kit {
namespace {

constexpr double most_spread = 0.125, most_wind_cells = 0.25;
constexpr double most_work = 5e7;       // cells times steps of one call, about a tenth of a second
constexpr double most_zone_cells = 64;  // of a zone's radius

}  // namespace

Pheromone::Pheromone(const Settings& settings) : settings_(settings) {
  const auto refuse = [](const char* name, double value, const char* why) {
    throw std::invalid_argument(fmt::format("{} = {:g} of a pheromone: {}", name, value, why));
  };
  for (const auto& [name, value] : {std::pair("width", settings.width_m), std::pair("height", settings.height_m),
                                    std::pair("cell", settings.cell_m), std::pair("cap", settings.cap)})
    if (!(value > 0) || !std::isfinite(value)) refuse(name, value, "must be positive");
  for (const auto& [name, value] :
       {std::pair("half_life", settings.half_life_s), std::pair("linear", settings.linear_per_s),
        std::pair("diffusion", settings.diffusion_m2_s), std::pair("cut_off", settings.cut_off)})
    if (!(value >= 0) || !std::isfinite(value)) refuse(name, value, "must be 0 or more");
  if (!std::isfinite(settings.wind_x_m_s) || !std::isfinite(settings.wind_y_m_s))
    refuse("wind", settings.wind_x_m_s, "must be a number");
  const double columns = std::ceil(settings.width_m / settings.cell_m - 1e-9),
               rows = std::ceil(settings.height_m / settings.cell_m - 1e-9);
  if (columns * rows > static_cast<double>(max_cells))
    refuse("cell", settings.cell_m,
           fmt::format("makes {:.0f} x {:.0f} cells, and the limit is {}; use larger cells", columns, rows, max_cells)
               .c_str());
  columns_ = std::max(1, static_cast<int>(columns));
  rows_ = std::max(1, static_cast<int>(rows));
  cells_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);
  next_ = cells_;
}

int Pheromone::cell_at(const hal::Point& place) const {
  const double column = std::floor((place.x_m + settings_.width_m / 2) / settings_.cell_m),
               row = std::floor((place.y_m + settings_.height_m / 2) / settings_.cell_m);
  if (!(column >= 0 && column < columns_ && row >= 0 && row < rows_)) return -1;
  return static_cast<int>(index(static_cast<int>(column), static_cast<int>(row)));
}

hal::Point Pheromone::centre_of(int cell) const {
  return {(cell % columns_ + 0.5) * settings_.cell_m - settings_.width_m / 2,
          (cell / columns_ + 0.5) * settings_.cell_m - settings_.height_m / 2};
}

void Pheromone::lay_in(int cell, double amount) {
  if (cell < 0 || cell >= static_cast<int>(cells_.size()) || !(amount > 0)) return;
  double& here = cells_[static_cast<std::size_t>(cell)];
  here = std::min(settings_.cap, here + amount);
}

double Pheromone::steps(double seconds) const {
  const double cell = settings_.cell_m;
  const double pace = std::max({settings_.diffusion_m2_s / (cell * cell * most_spread),
                                std::abs(settings_.wind_x_m_s) / (cell * most_wind_cells),
                                std::abs(settings_.wind_y_m_s) / (cell * most_wind_cells)});
  const double steps = std::ceil(seconds * pace), most = std::floor(most_work / static_cast<double>(cells_.size()));
  if (steps > most)
    throw std::invalid_argument(
        fmt::format("a pheromone with this diffusion or wind needs {:.0f} steps of {} cells for {:g} s, and the limit "
                    "is {:.0f}; use larger cells",
                    steps, cells_.size(), seconds, most));
  return steps;
}

void Pheromone::pass(double seconds) {
  if (!(seconds > 0)) return;
  const double all = steps(seconds);
  decay(seconds);
  for (int i = 0; i < static_cast<int>(all); ++i) spread(seconds / all);
  for (double& here : cells_)
    if (here < settings_.cut_off) here = 0;
}

void Pheromone::decay(double seconds) {
  const double left = settings_.half_life_s > 0 ? hal::fixed::exp2(-seconds / settings_.half_life_s) : 1;
  const double less = settings_.linear_per_s * seconds;
  for (double& here : cells_) here = std::max(0.0, here * left - less);
}

void Pheromone::spread(double seconds) {
  const double cell = settings_.cell_m, share = settings_.diffusion_m2_s * seconds / (cell * cell),
               wind_x = settings_.wind_x_m_s * seconds / cell, wind_y = settings_.wind_y_m_s * seconds / cell;
  next_ = cells_;
  // from a cell to the next one along a row or column; what one loses the other gains
  const auto flow = [&](std::size_t here, std::size_t there, double wind) {
    const double moved =
        share * (cells_[here] - cells_[there]) + (wind > 0 ? wind * cells_[here] : wind * cells_[there]);
    next_[here] -= moved;
    next_[there] += moved;
  };
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      if (column + 1 < columns_) flow(index(column, row), index(column + 1, row), wind_x);
      if (row + 1 < rows_) flow(index(column, row), index(column, row + 1), wind_y);
    }
  for (double& here : next_) here = std::min(settings_.cap, here);
  cells_.swap(next_);
}

double Pheromone::at(const hal::Point& place) const {
  const int cell = cell_at(place);
  return cell < 0 ? 0 : in_cell(cell);
}

hal::Point Pheromone::gradient(const hal::Point& place) const {
  const int cell = cell_at(place);
  if (cell < 0) return {};
  const int column = cell % columns_, row = cell / columns_;
  const auto slope = [&](int low_column, int low_row, int high_column, int high_row) {
    const int apart = high_column - low_column + high_row - low_row;
    if (apart == 0) return 0.0;
    return (cells_[index(high_column, high_row)] - cells_[index(low_column, low_row)]) / (apart * settings_.cell_m);
  };
  return {slope(std::max(column - 1, 0), row, std::min(column + 1, columns_ - 1), row),
          slope(column, std::max(row - 1, 0), column, std::min(row + 1, rows_ - 1))};
}

std::uint32_t Pheromone::zones(const hal::Pose& robot, int count, double opening_rad, double radius_m,
                               double least) const {
  if (count < 1 || count > 32 || !(opening_rad > 0 && opening_rad <= 2 * std::numbers::pi) || !(radius_m > 0))
    throw std::invalid_argument(
        "zones must be 1 to 32, within an opening of at most a full circle and a positive radius");
  if (radius_m > most_zone_cells * settings_.cell_m)
    throw std::invalid_argument(fmt::format("zones of {:g} m cover {:.0f} cells, and the limit is {}; use larger cells",
                                            radius_m, radius_m / settings_.cell_m, most_zone_cells));
  std::uint32_t bits = 0;
  const auto place = [this](double at_m, double side_m, int count_of) {
    return std::clamp(static_cast<int>(std::floor((at_m + side_m / 2) / settings_.cell_m)), 0, count_of - 1);
  };
  const int low_column = place(robot.x_m - radius_m, settings_.width_m, columns_),
            high_column = place(robot.x_m + radius_m, settings_.width_m, columns_),
            low_row = place(robot.y_m - radius_m, settings_.height_m, rows_),
            high_row = place(robot.y_m + radius_m, settings_.height_m, rows_);
  for (int row = low_row; row <= high_row; ++row)
    for (int column = low_column; column <= high_column; ++column) {
      const std::size_t cell = index(column, row);
      if (!(cells_[cell] >= least) || cells_[cell] == 0) continue;
      const hal::Point centre = centre_of(static_cast<int>(cell));
      const double x = centre.x_m - robot.x_m, y = centre.y_m - robot.y_m;
      if (x * x + y * y > radius_m * radius_m) continue;
      const double bearing = std::remainder(hal::fixed::atan2(y, x) - robot.heading_rad, 2 * std::numbers::pi);
      const double from_left = (opening_rad / 2 - bearing) / opening_rad * count;
      if (from_left < 0 || from_left >= count) continue;
      bits |= 1U << (count - 1 - static_cast<int>(from_left));
    }
  return bits;
}

void Pheromone::draw(lab::Lab& lab, const hal::Projection& arena, double full, hal::Colour colour) const {
  // as coarse as a drawing has room for
  int coarse = 1;
  const auto cells_of = [](int n, int by) { return (n + by - 1) / by; };
  while (static_cast<std::size_t>(cells_of(columns_, coarse)) * static_cast<std::size_t>(cells_of(rows_, coarse)) >
         hal::Drawing::max_cells / 4)
    ++coarse;
  const int columns = cells_of(columns_, coarse), rows = cells_of(rows_, coarse);
  hal::Raster raster{
      .corner = arena.to_arena({-settings_.width_m / 2, -settings_.height_m / 2, 0}),
      .cell_m = settings_.cell_m * coarse / arena.scale,
      .columns = columns,
      .cells = std::vector<std::uint8_t>(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)),
      .colour = colour};
  bool any = false;
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      const double here = cells_[index(column, row)];
      if (!(here > 0)) continue;
      any = true;
      auto& shown = raster.cells[static_cast<std::size_t>(row / coarse) * static_cast<std::size_t>(columns) +
                                 static_cast<std::size_t>(column / coarse)];
      shown = std::max(shown, static_cast<std::uint8_t>(std::clamp(here / full, 0.0, 1.0) * 254 + 1));
    }
  if (any) lab.draw(std::move(raster));
}

}  // namespace arkmesh::scenarios::kit
