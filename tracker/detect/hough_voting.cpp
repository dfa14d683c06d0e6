// See hough_voting.hpp.
#include "tracker/detect/hough_voting.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tracker/detect/wide.hpp"

namespace arkmesh::tracker {
namespace {

// Sobel steps of one row, 64 times the grey levels a pixel.
void steps_of_row(const std::int16_t* __restrict above, const std::int16_t* __restrict here,
                  const std::int16_t* __restrict below, std::int16_t* __restrict step_x,
                  std::int16_t* __restrict step_y, int width) {
  for (int x = 1; x < width - 1; ++x) {
    const int right = above[x + 1] + 2 * here[x + 1] + below[x + 1],
              left = above[x - 1] + 2 * here[x - 1] + below[x - 1];
    const int down = below[x - 1] + 2 * below[x] + below[x + 1], up = above[x - 1] + 2 * above[x] + above[x + 1];
    step_x[x] = static_cast<std::int16_t>(right - left);
    step_y[x] = static_cast<std::int16_t>(down - up);
  }
}

// Sum of 3 x 3 votes for one row.
void smooth_row(const std::uint16_t* __restrict above, const std::uint16_t* __restrict here,
                const std::uint16_t* __restrict below, std::uint16_t* __restrict out, int width) {
  for (int x = 1; x < width - 1; ++x) {
    const int sum = above[x - 1] + above[x] + above[x + 1] + here[x - 1] + here[x] + here[x + 1] + below[x - 1] +
                    below[x] + below[x + 1];
    out[x] = static_cast<std::uint16_t>(sum);
  }
}

constexpr int run = 64;

ARKMESH_WIDE std::uint16_t most_of(const std::uint16_t* votes, int count) {
  std::uint16_t most = 0;
  for (int x = 0; x < count; ++x) most = votes[x] > most ? votes[x] : most;
  return most;
}

}  // namespace

void HoughVoting::look_at(const DownsampledImage& picture, double min_step) {
  width_ = picture.width;
  height_ = picture.height;
  edges_.clear();
  if (width_ < 3 || height_ < 3) return;
  step_x_.assign(static_cast<std::size_t>(width_), 0);
  step_y_.assign(static_cast<std::size_t>(width_), 0);
  const int least = static_cast<int>(64 * min_step), min_squared = least * least;
  for (int y = 1; y < height_ - 1; ++y) {
    steps_of_row(picture.row(y - 1), picture.row(y), picture.row(y + 1), step_x_.data(), step_y_.data(), width_);
    for (int x = 1; x < width_ - 1; ++x) {
      const int step_x = step_x_[static_cast<std::size_t>(x)], step_y = step_y_[static_cast<std::size_t>(x)];
      const int squared = step_x * step_x + step_y * step_y;
      if (squared < min_squared) continue;
      const float inverse = 1.0F / std::sqrt(static_cast<float>(squared));
      edges_.push_back({x, y, static_cast<float>(step_x) * inverse, static_cast<float>(step_y) * inverse});
    }
  }
}

void HoughVoting::find(double min_r, double max_r, bool darker, double min_votes, std::vector<CircleVote>& found) {
  // The margin makes room for centres outside the picture, so that no vote needs a check.
  const int margin = static_cast<int>(std::ceil(max_r)) + 2;
  const int wide = width_ + 2 * margin, high = height_ + 2 * margin;
  votes_.assign(static_cast<std::size_t>(wide) * static_cast<std::size_t>(high), 0);
  const int radii = std::max(1, static_cast<int>(std::lround(max_r - min_r)) + 1);
  const float step = radii > 1 ? static_cast<float>((max_r - min_r) / (radii - 1)) : 0.0F;
  // From a bright surrounding into a dark disc is against the direction of the step, and the other way round.
  const float sign = darker ? -1.0F : 1.0F;
  for (const Edge& edge : edges_) {
    const float x = static_cast<float>(edge.x + margin) + 0.5F, y = static_cast<float>(edge.y + margin) + 0.5F;
    float r = sign * static_cast<float>(radii > 1 ? min_r : (min_r + max_r) / 2);
    for (int i = 0; i < radii; ++i, r += sign * step) {
      const int at_x = static_cast<int>(x + r * edge.towards_x), at_y = static_cast<int>(y + r * edge.towards_y);
      ++votes_[static_cast<std::size_t>(at_y) * static_cast<std::size_t>(wide) + static_cast<std::size_t>(at_x)];
    }
  }

  smooth_.resize(votes_.size());  // its border is never looked at
  for (int y = 1; y < high - 1; ++y) {
    const std::uint16_t* here = votes_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(wide);
    smooth_row(here - wide, here, here + wide, smooth_.data() + (here - votes_.data()), wide);
  }

  // Peaks: at least as high as all neighbours, higher than those before it.
  const double middle_r = (min_r + max_r) / 2,
               whole = 2 * 3.14159265358979 * middle_r * 2;  // an edge is about two pixels wide
  const int least = std::max(3, static_cast<int>(min_votes * whole));
  const std::size_t before = found.size();
  for (int y = 2; y < high - 2; ++y) {
    const std::uint16_t* here = smooth_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(wide);
    for (int x = 2; x < wide - 2; ++x) {
      // nearly everywhere there is none
      if ((x - 2) % run == 0 && most_of(here + x, std::min(run, wide - 2 - x)) < least) {
        x += run - 1;
        continue;
      }
      const int value = here[x];
      if (value < least) continue;
      const std::uint16_t *above = here - wide + x, *below = here + wide + x;
      if (value <= above[-1] || value <= above[0] || value <= above[1] || value <= here[x - 1]) continue;
      if (value < here[x + 1] || value < below[-1] || value < below[0] || value < below[1]) continue;
      found.push_back({.x = static_cast<double>(x - margin),
                       .y = static_cast<double>(y - margin),
                       .r = middle_r,
                       .darker = darker,
                       .votes = static_cast<float>(value / whole)});
    }
  }
  std::sort(found.begin() + static_cast<std::ptrdiff_t>(before), found.end(),
            [](const CircleVote& a, const CircleVote& b) {
              return a.votes != b.votes ? a.votes > b.votes : a.y != b.y ? a.y < b.y : a.x < b.x;
            });
}

}  // namespace arkmesh::tracker
