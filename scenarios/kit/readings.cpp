#include "scenarios/kit/readings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace arkmesh::scenarios::kit {
namespace {

double with_noise(double reading, const Readings::Column& column, hal::RandomStream& random) {
  using Kind = Readings::Column::Kind;
  const double said = reading + column.noise * random.normal();
  if (column.kind == Kind::angle) return std::remainder(said, 2 * std::numbers::pi);
  return std::clamp(column.kind == Kind::whole_number ? std::round(said) : said, column.low, column.high);
}

}  // namespace

Readings::Readings(double every_s, std::vector<Column> columns, std::uint64_t seed, const std::string& stream)
    : every_(0),
      columns_(std::move(columns)),
      is_perfect_(every_s == 0 && std::ranges::all_of(columns_, [](const Column& c) { return c.noise == 0; })),
      random_(seed, stream) {
  if (!(every_s >= 0) || every_s > 1e6)
    throw std::invalid_argument(fmt::format("readings every {:g} s are not possible; give 0 to 1e6 s", every_s));
  for (const Column& column : columns_)
    if (!(column.noise >= 0) || !std::isfinite(column.noise))
      throw std::invalid_argument(fmt::format("noise of {:g} is not possible; give 0 or more", column.noise));
  every_ = hal::LabTime{std::llround(every_s * 1e6)};
}

void Readings::pass(const hal::PoseFrame& frame, std::span<double> readings) {
  if (is_perfect_) return;
  const std::size_t n = columns_.size();
  const bool renews = frame.stamp >= renews_at_;
  if (renews && every_.count() > 0) renews_at_ = (frame.stamp / every_ + 1) * every_;  // the next whole multiple
  for (std::size_t row = 0; row < frame.robots.size(); ++row) {
    const std::span<double> own = readings.subspan(row * n, n);
    const auto held = renews ? held_.end() : held_.find(frame.robots[row].robot);
    if (held != held_.end()) {
      std::ranges::copy(held->second, own.begin());
      continue;
    }
    for (std::size_t c = 0; c < n; ++c) {
      const bool is_there = columns_[c].kind == Column::Kind::angle || own[c] >= columns_[c].low;
      if (is_there && columns_[c].noise > 0) own[c] = with_noise(own[c], columns_[c], random_);
    }
    if (every_.count() > 0) held_[frame.robots[row].robot].assign(own.begin(), own.end());
  }
}

}  // namespace arkmesh::scenarios::kit
