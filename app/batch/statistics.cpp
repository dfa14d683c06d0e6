#include "app/batch/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numeric>

namespace arkmesh::app {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

// Half of the interval that holds 95 % of Student's t.
double t95(double degrees) {
  return boost::math::quantile(boost::math::students_t(degrees), 0.975);
}

double squares(const std::vector<double>& sample, double mean) {
  return std::accumulate(sample.begin(), sample.end(), 0.0,
                         [&](double sum, double x) { return sum + (x - mean) * (x - mean); });
}

// Of sorted numbers, how many more of `second` are above than below those of `first`, as a share of all pairs.
double delta(const std::vector<double>& first, const std::vector<double>& second) {
  double balance = 0;
  for (const double x : second) {
    const auto [low, high] = std::equal_range(first.begin(), first.end(), x);
    balance += static_cast<double>((low - first.begin()) - (first.end() - high));
  }
  return balance / (static_cast<double>(first.size()) * static_cast<double>(second.size()));
}

}  // namespace

SampleSummary summarize(std::vector<double> sample) {
  std::ranges::sort(sample);
  const std::size_t n = sample.size();
  SampleSummary out{.n = n, .min = sample.front(), .max = sample.back()};
  out.mean = std::accumulate(sample.begin(), sample.end(), 0.0) / static_cast<double>(n);
  out.median = (sample[(n - 1) / 2] + sample[n / 2]) / 2;
  if (n < 2) {
    out.sd = out.se = out.low95 = out.high95 = unknown;
    return out;
  }
  out.sd = std::sqrt(squares(sample, out.mean) / static_cast<double>(n - 1));
  out.se = out.sd / std::sqrt(static_cast<double>(n));
  const double half = t95(static_cast<double>(n - 1)) * out.se;
  out.low95 = out.mean - half;
  out.high95 = out.mean + half;
  return out;
}

SampleDifference compare(const std::vector<double>& first, const std::vector<double>& second) {
  const SampleSummary a = summarize(first), b = summarize(second);
  SampleDifference out{
      .difference = b.mean - a.mean, .low95 = unknown, .high95 = unknown, .hedges_g = unknown, .cliffs_delta = 0};
  std::vector<double> sorted_first = first;
  std::ranges::sort(sorted_first);
  out.cliffs_delta = delta(sorted_first, second);
  if (a.n < 2 || b.n < 2) return out;
  const double na = static_cast<double>(a.n), nb = static_cast<double>(b.n), va = a.se * a.se, vb = b.se * b.se;
  const double pooled = std::sqrt(((na - 1) * a.sd * a.sd + (nb - 1) * b.sd * b.sd) / (na + nb - 2));
  if (pooled == 0) {  // all alike
    out.low95 = out.high95 = out.difference;
    if (out.difference == 0) out.hedges_g = 0;
    return out;
  }
  // Welch and Satterthwaite's degrees of freedom
  const double degrees = (va + vb) * (va + vb) / (va * va / (na - 1) + vb * vb / (nb - 1));
  const double half = t95(degrees) * std::sqrt(va + vb);
  out.low95 = out.difference - half;
  out.high95 = out.difference + half;
  out.hedges_g = out.difference / pooled * (1 - 3 / (4 * (na + nb) - 9));
  return out;
}

}  // namespace arkmesh::app
