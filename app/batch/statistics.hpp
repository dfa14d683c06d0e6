// What a sample says about its mean, and two samples about their difference.
#pragma once

#include <vector>

namespace arkmesh::app {

// Of at least one number. With one number sd, se and the interval are NaN.
struct SampleSummary {
  std::size_t n = 0;
  double mean = 0, sd = 0, se = 0;
  double low95 = 0, high95 = 0;  // of the mean, Student's t with n - 1 degrees of freedom
  double min = 0, median = 0, max = 0;
};
SampleSummary summarize(std::vector<double> sample);

// How `second` differs from `first`, each of at least one number; NaN where one is too small to tell.
struct SampleDifference {
  double difference = 0;         // of means, second minus first
  double low95 = 0, high95 = 0;  // of it, by Welch: the variances may differ (Welch, Biometrika 34, 1947)
  double hedges_g = 0;           // in pooled standard deviations, corrected for small samples (Hedges, 1981)
  double cliffs_delta = 0;       // P(second > first) - P(second < first) (Cliff, 1993)
};
SampleDifference compare(const std::vector<double>& first, const std::vector<double>& second);

}  // namespace arkmesh::app
