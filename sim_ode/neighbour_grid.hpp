// Points sorted into square cells, so that who is near whom costs little. Rebuilt as a whole; order depends on the
// points only.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace arkmesh::sim_ode {

class NeighbourGrid {
 public:
  // Covers an arena around the origin; points outside count to the cells at its edge. Cells are larger than asked for
  // where an arena is so empty that there would be many more of them than points.
  NeighbourGrid(double width_m, double height_m, double cell_m, int points)
      : left_(-width_m / 2),
        bottom_(-height_m / 2),
        per_m_(1 / std::max(cell_m, std::sqrt(width_m * height_m / (8.0 * points + 64)))),
        columns_(std::max(1, static_cast<int>(std::ceil(width_m * per_m_)))),
        rows_(std::max(1, static_cast<int>(std::ceil(height_m * per_m_)))),
        first_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1) {}

  // A point where build() found it, to within `rounded_m` each way.
  struct Member {
    float x, y;
    int number;
  };
  static constexpr double rounded_m = 1e-5;

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
    for (std::size_t i = x.size(); i-- > 0;)
      members_[static_cast<std::size_t>(--first_[static_cast<std::size_t>(cell_[i])])] = {
          static_cast<float>(x[i]), static_cast<float>(y[i]), static_cast<int>(i)};
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

  // The numbers of all points within `reach_m` of a place, rounding included, row by row. In force until the next call
  // with `room`.
  std::span<const int> gather(double x, double y, double reach_m, std::vector<int>& room) const {
    const auto px = static_cast<float>(x), py = static_cast<float>(y);
    const double far_m = reach_m + 2 * rounded_m;
    const auto far2 = static_cast<float>(far_m * far_m);
    const int from = column(x - far_m), to = column(x + far_m), top = row(y + far_m);
    std::size_t found = 0;
    for (int r = row(y - far_m); r <= top; ++r) {
      const auto begin = static_cast<std::size_t>(first_[static_cast<std::size_t>(r * columns_ + from)]);
      const auto end = static_cast<std::size_t>(first_[static_cast<std::size_t>(r * columns_ + to) + 1]);
      if (room.size() < found + (end - begin)) room.resize(2 * (found + (end - begin)));
      // without a branch: whether somebody is near cannot be foreseen
      int* const place = room.data();
      for (std::size_t k = begin; k < end; ++k) {
        const Member& member = members_[k];
        const float dx = member.x - px, dy = member.y - py;
        place[found] = member.number;
        found += dx * dx + dy * dy <= far2;
      }
    }
    return std::span(room).first(found);
  }

  // For visits that are soon to come: fetches the cells, then, a while later, who is in them.
  void fetch_cells(double x, double y, double reach_m) const {
    const int from = column(x - reach_m), top = row(y + reach_m);
    for (int r = row(y - reach_m); r <= top; ++r)
      __builtin_prefetch(&first_[static_cast<std::size_t>(r * columns_ + from)]);
  }
  void fetch_members(double x, double y, double reach_m) const {
    const int from = column(x - reach_m), top = row(y + reach_m);
    for (int r = row(y - reach_m); r <= top; ++r)
      __builtin_prefetch(members_.data() + first_[static_cast<std::size_t>(r * columns_ + from)]);
  }

  // Calls visit(member, other) once for each pair less than `reach_m` apart, rounding apart; reach_m is at most a
  // cell's side.
  template <class Visit>
  void visit_pairs(double reach_m, Visit&& visit) const {
    const auto reach2 = static_cast<float>(reach_m * reach_m);
    for (int r = 0; r < rows_; ++r) {
      for (int c = 0; c < columns_; ++c) {
        const std::size_t here = static_cast<std::size_t>(r * columns_ + c);
        if (first_[here] == first_[here + 1]) continue;
        // the rest of this cell and the one to the right; then three of the row above
        const auto right_end = static_cast<std::size_t>(first_[c + 1 < columns_ ? here + 2 : here + 1]);
        const std::size_t above = here + static_cast<std::size_t>(columns_);
        const bool top = r + 1 == rows_;
        const auto above_begin = static_cast<std::size_t>(top ? 0 : first_[c > 0 ? above - 1 : above]);
        const auto above_end = static_cast<std::size_t>(top ? 0 : first_[c + 1 < columns_ ? above + 2 : above + 1]);
        for (auto k = static_cast<std::size_t>(first_[here]); k < static_cast<std::size_t>(first_[here + 1]); ++k) {
          const Member one = members_[k];
          const auto compare = [&](const Member& other) {
            const float dx = other.x - one.x, dy = other.y - one.y;
            if (dx * dx + dy * dy < reach2) visit(one.number, other.number);
          };
          for (std::size_t m = k + 1; m < right_end; ++m) compare(members_[m]);
          for (std::size_t m = above_begin; m < above_end; ++m) compare(members_[m]);
        }
      }
    }
  }

 private:
  int column(double x) const { return std::clamp(static_cast<int>((x - left_) * per_m_), 0, columns_ - 1); }
  int row(double y) const { return std::clamp(static_cast<int>((y - bottom_) * per_m_), 0, rows_ - 1); }

  double left_, bottom_, per_m_;
  int columns_, rows_;
  std::vector<int> first_;  // of each cell in members_, and the end
  std::vector<Member> members_;
  std::vector<int> cell_;  // by point
};

}  // namespace arkmesh::sim_ode
