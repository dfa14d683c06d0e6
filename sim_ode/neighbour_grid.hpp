// Points sorted into square cells, so that who is near whom costs little. Rebuilt as a whole; order depends on the points only.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace arkmesh::sim_ode {

class NeighbourGrid {
 public:
  // Covers an arena around the origin; points outside count to the cells at its edge.
  NeighbourGrid(double width_m, double height_m, double cell_m)
      : left_(-width_m / 2), bottom_(-height_m / 2), per_m_(1 / cell_m),
        columns_(std::max(1, static_cast<int>(std::ceil(width_m / cell_m)))),
        rows_(std::max(1, static_cast<int>(std::ceil(height_m / cell_m)))),
        first_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1) {}

  void build(std::span<const double> x, std::span<const double> y) {
    cell_.resize(x.size());
    members_.resize(x.size());
    std::fill(first_.begin(), first_.end(), 0);
    for (std::size_t i = 0; i < x.size(); ++i) {
      cell_[i] = row(y[i]) * columns_ + column(x[i]);
      ++first_[static_cast<std::size_t>(cell_[i])];
    }
    int total = 0;
    for (int& first : first_) first = total += first;
    // backwards, so that members ascend within a cell
    for (std::size_t i = x.size(); i-- > 0;) members_[static_cast<std::size_t>(--first_[static_cast<std::size_t>(cell_[i])])] = static_cast<int>(i);
  }

  // Calls visit(member) for everything in the cells within `reach_m` of a place: all that is within reach, and more.
  template <class Visit>
  void visit_near(double x, double y, double reach_m, Visit&& visit) const {
    const int from = column(x - reach_m), to = column(x + reach_m), top = row(y + reach_m);
    for (int r = row(y - reach_m); r <= top; ++r) {
      // the cells of a row lie side by side
      const auto begin = static_cast<std::size_t>(first_[static_cast<std::size_t>(r * columns_ + from)]);
      const auto end = static_cast<std::size_t>(first_[static_cast<std::size_t>(r * columns_ + to) + 1]);
      for (std::size_t k = begin; k < end; ++k) visit(members_[k]);
    }
  }

 private:
  int column(double x) const { return std::clamp(static_cast<int>((x - left_) * per_m_), 0, columns_ - 1); }
  int row(double y) const { return std::clamp(static_cast<int>((y - bottom_) * per_m_), 0, rows_ - 1); }

  double left_, bottom_, per_m_;
  int columns_, rows_;
  std::vector<int> first_;     // of each cell in members_, and the end
  std::vector<int> members_, cell_;
};

}  // namespace arkmesh::sim_ode
