#include "tracker/follow/assignment.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <queue>
#include <tuple>

namespace arkmesh::tracker {
namespace {

constexpr double unreached = std::numeric_limits<double>::infinity();

// The pairs of one row, by column. Each row also has a column of its own that means "alone", at no cost.
struct Graph {
  std::vector<Pairing> pairs;
  std::vector<std::size_t> first;  // of each row; one more than there are rows
};

Graph by_row(std::uint32_t rows, std::span<const Pairing> possible) {
  Graph graph;
  for (const Pairing& pair : possible)
    if (pair.gain > 0) graph.pairs.push_back(pair);
  std::sort(graph.pairs.begin(), graph.pairs.end(),
            [](const Pairing& a, const Pairing& b) { return std::tie(a.row, a.column) < std::tie(b.row, b.column); });
  graph.first.assign(rows + 1, 0);
  for (const Pairing& pair : graph.pairs) ++graph.first[pair.row + 1];
  for (std::uint32_t row = 0; row < rows; ++row) graph.first[row + 1] += graph.first[row];
  return graph;
}

class Solver {
 public:
  Solver(std::uint32_t rows, std::uint32_t columns, std::span<const Pairing> possible)
      : graph_(by_row(rows, possible)),
        columns_(columns),
        column_of_(rows, alone),
        row_of_(columns + rows, alone),
        row_price_(rows, 0),
        column_price_(columns + rows, 0),
        distance_(columns + rows, unreached),
        reached_from_(columns + rows, 0),
        settled_(columns + rows) {}

  std::vector<std::int32_t> solve() {
    for (std::uint32_t row = 0; row < column_of_.size(); ++row) enter(row);
    for (std::int32_t& column : column_of_)
      if (column >= static_cast<std::int32_t>(columns_)) column = alone;
    return column_of_;
  }

 private:
  using Step = std::pair<double, std::uint32_t>;  // distance, column

  // Finds the cheapest chain of re-assignments that gives `row` a column, and carries it out.
  void enter(std::uint32_t row) {
    std::priority_queue<Step, std::vector<Step>, std::greater<>> open;
    std::vector<std::uint32_t> touched;
    const auto reach = [&](std::uint32_t from, double base) {
      const auto offer = [&](std::uint32_t column, double cost) {
        const double there = base + cost - column_price_[column];
        if (settled_[column] || there >= distance_[column]) return;
        if (distance_[column] == unreached) touched.push_back(column);
        distance_[column] = there;
        reached_from_[column] = from;
        open.emplace(there, column);
      };
      for (std::size_t i = graph_.first[from]; i < graph_.first[from + 1]; ++i)
        offer(graph_.pairs[i].column, -graph_.pairs[i].gain);
      offer(columns_ + from, 0);
    };

    reach(row, 0);
    std::uint32_t end = 0;
    for (;;) {
      assert(!open.empty());  // the row's own column is always free for it
      const auto [there, column] = open.top();
      open.pop();
      if (settled_[column] || there > distance_[column]) continue;
      settled_[column] = true;
      end = column;
      const std::int32_t holder = row_of_[column];
      if (holder == alone) break;
      reach(static_cast<std::uint32_t>(holder), there - row_price_[holder]);
    }

    // Prices keep every remaining pair from looking cheaper than it is.
    const double length = distance_[end];
    for (const std::uint32_t column : touched) {
      if (settled_[column] && column != end) {
        row_price_[row_of_[column]] += length - distance_[column];
        column_price_[column] -= length - distance_[column];
      }
    }
    row_price_[row] = length;
    for (const std::uint32_t column : touched) {
      distance_[column] = unreached;
      settled_[column] = false;
    }

    for (std::uint32_t column = end;;) {
      const std::uint32_t from = reached_from_[column];
      const std::int32_t before = column_of_[from];
      column_of_[from] = static_cast<std::int32_t>(column);
      row_of_[column] = static_cast<std::int32_t>(from);
      if (from == row) break;
      column = static_cast<std::uint32_t>(before);
    }
  }

  Graph graph_;
  std::uint32_t columns_;
  std::vector<std::int32_t> column_of_, row_of_;
  std::vector<double> row_price_, column_price_, distance_;
  std::vector<std::uint32_t> reached_from_;
  std::vector<bool> settled_;
};

}  // namespace

std::vector<std::int32_t> assign(std::uint32_t rows, std::uint32_t columns, std::span<const Pairing> possible) {
  return Solver(rows, columns, possible).solve();
}

}  // namespace arkmesh::tracker
