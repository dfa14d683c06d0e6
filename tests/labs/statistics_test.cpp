// Statistics of batches, against values from textbooks and published tables.
#include "app/batch/statistics.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace arkmesh;

TEST_CASE("statistics: a sample's mean and its interval") {
  // Student's t of 9 degrees of freedom is 2.262 at 0.975
  const app::SampleSummary s = app::summarize({3, 1, 2, 5, 4, 8, 7, 6, 10, 9});
  CHECK(s.n == 10);
  CHECK(s.mean == doctest::Approx(5.5));
  CHECK(s.sd == doctest::Approx(3.02765));
  CHECK(s.se == doctest::Approx(0.957427));
  CHECK(s.high95 - s.mean == doctest::Approx(2.262 * 0.957427).epsilon(1e-3));
  CHECK(s.median == 5.5);
  CHECK(s.min == 1);
  CHECK(s.max == 10);
  const app::SampleSummary one = app::summarize({4});
  CHECK(one.mean == 4);
  CHECK(std::isnan(one.sd));
  CHECK(std::isnan(one.low95));
}

TEST_CASE("statistics: two samples differ by as much as Welch, Hedges and Cliff say") {
  const app::SampleDifference d = app::compare({1, 2, 3, 4}, {3, 4, 5, 6, 7});
  CHECK(d.difference == doctest::Approx(2.5));
  // variances 5/3 and 5/2: se = sqrt(5/12 + 1/2), 6.98 degrees of freedom, t = 2.366
  CHECK(d.high95 - d.difference == doctest::Approx(2.366 * std::sqrt(5.0 / 12 + 0.5)).epsilon(1e-3));
  // pooled variance (3 * 5/3 + 4 * 5/2) / 7
  CHECK(d.hedges_g == doctest::Approx(2.5 / std::sqrt(15.0 / 7) * (1 - 3.0 / 27)));
  // of 20 pairs 16 are above, 2 alike, 2... : (3>1,2; 3=3; 3<4) 2-1, (4>1,2,3; 4=4) 3, then 4, 4, 4
  CHECK(d.cliffs_delta == doctest::Approx((1 + 3 + 4 + 4 + 4) / 20.0));
  const app::SampleDifference same = app::compare({2, 2}, {2, 2});
  CHECK(same.difference == 0);
  CHECK(same.hedges_g == 0);
  CHECK(same.cliffs_delta == 0);
  CHECK(std::isnan(app::compare({1}, {2, 3}).low95));
}
