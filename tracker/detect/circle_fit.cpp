// See circle_fit.hpp.
#include "tracker/detect/circle_fit.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "tracker/detect/wide.hpp"

namespace arkmesh::tracker {
namespace {

constexpr double tau = 6.283185307179586;

constexpr std::size_t all_rays = 48, most_between = 40;

struct EdgeDirections {
  std::array<float, all_rays> x{}, y{};
  EdgeDirections() {
    for (std::size_t i = 0; i < all_rays; ++i) {
      x[i] = static_cast<float>(std::cos(tau * static_cast<double>(i) / all_rays));
      y[i] = static_cast<float>(std::sin(tau * static_cast<double>(i) / all_rays));
    }
  }
};
const EdgeDirections towards;

// Indices of the pixels nearest to evenly spaced places; `y` and `x` are already half a pixel further.
ARKMESH_WIDE void nearest_pixels(float x, float y, float dx, float dy, int width, int count,
                                 std::int32_t* __restrict index) {
  for (int k = 0; k < count; ++k) {
    const float step = static_cast<float>(k);
    index[k] = static_cast<std::int32_t>(y + step * dy) * width + static_cast<std::int32_t>(x + step * dx);
  }
}

// Grey levels between pixels at evenly spaced places, as DownsampledImage::at has them: loops of their own so that they
// vectorise.
ARKMESH_WIDE void between_pixels(const std::int16_t* __restrict grey, int width, float x, float y, float dx, float dy,
                                 int count, float* __restrict along) {
  std::array<std::int32_t, most_between> index;
  std::array<float, most_between> right, down;
  std::array<std::array<std::int32_t, most_between>, 4> corner;
  for (int k = 0; k < count; ++k) {
    const float step = static_cast<float>(k), px = x + step * dx, py = y + step * dy;
    const std::int32_t ix = static_cast<std::int32_t>(px), iy = static_cast<std::int32_t>(py);
    const auto i = static_cast<std::size_t>(k);
    index[i] = iy * width + ix;
    right[i] = px - static_cast<float>(ix);
    down[i] = py - static_cast<float>(iy);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const std::int16_t* const upper = grey + index[i];
    corner[0][i] = upper[0], corner[1][i] = upper[1], corner[2][i] = upper[width], corner[3][i] = upper[width + 1];
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const float top = static_cast<float>(corner[0][i]) + right[i] * static_cast<float>(corner[1][i] - corner[0][i]),
                bottom = static_cast<float>(corner[2][i]) + right[i] * static_cast<float>(corner[3][i] - corner[2][i]);
    along[i] = (top + down[i] * (bottom - top)) * 0.125F;
  }
}

// Rise of the grey level round each sample, over `Reach` samples on either side.
template <int Reach>
void rises(const float* __restrict along, int count, float* __restrict rise) {
  for (int k = Reach; k < count - Reach; ++k) {
    float sum = along[k + 1] - along[k - 1];
    for (int j = 2; j <= Reach; ++j) sum += along[k + j] - along[k - j];
    rise[k] = sum * (1.0F / Reach);
  }
}

}  // namespace

void CircleFitter::sample(const DownsampledImage& picture, double x, double y, double r, const Span& span) {
  span_ = span;
  first_ = static_cast<float>(span.from * r);
  spacing_ = static_cast<float>((span.to - span.from) * r / (span.samples - 1));
  const float max_x = static_cast<float>(picture.width) - 1.001F, max_y = static_cast<float>(picture.height) - 1.001F;
  // Where pixels are much smaller than what is looked for, the nearest one is as good as a mix of four.
  const bool nearest = r > 11;
  const std::int16_t* grey = picture.grey.data();
  const int width = picture.width;
  const auto inside = [&](float px, float py) { return px >= 0 && py >= 0 && px <= max_x && py <= max_y; };
  std::array<float, max_samples> along;
  std::array<std::int32_t, max_samples> index;
  const int reach = span.reach;
  for (int i = 0; i < rays; i += span.every) {
    const auto ray = static_cast<std::size_t>(i);
    const float ux = towards.x[ray], uy = towards.y[ray];
    const float x0 = static_cast<float>(x) + first_ * ux, y0 = static_cast<float>(y) + first_ * uy, dx = spacing_ * ux,
                dy = spacing_ * uy;
    int known = span.samples;
    const float last = static_cast<float>(span.samples - 1);
    if (!inside(x0, y0) || !inside(x0 + last * dx, y0 + last * dy)) {
      known = 0;
      while (known < span.samples && inside(x0 + static_cast<float>(known) * dx, y0 + static_cast<float>(known) * dy))
        ++known;
    }
    known_[ray] = known;
    auto& step = step_[ray];
    step.fill(0);
    if (known < 2 * reach + 1) continue;
    if (nearest) {
      nearest_pixels(x0 + 0.5F, y0 + 0.5F, dx, dy, width, known, index.data());
      for (int k = 0; k < known; ++k)
        along[static_cast<std::size_t>(k)] = 0.125F * static_cast<float>(grey[index[static_cast<std::size_t>(k)]]);
    } else {
      static_assert(max_samples <= most_between);
      between_pixels(grey, width, x0, y0, dx, dy, known, along.data());
    }
    if (reach == 2)
      rises<2>(along.data(), known, step.data());
    else
      rises<3>(along.data(), known, step.data());
  }
}

// Along each ray the strongest edge near the circle, nearer ones preferred.
void CircleFitter::find_edges(const Fitted& circle, float window, bool darker, float min_step) {
  const float sign = darker ? 1.0F : -1.0F, per_sample = 1 / spacing_;
  const int half = static_cast<int>(window * per_sample) + 1;
  std::array<float, 2 * max_samples + 1> preference;
  for (int j = -half; j <= half && half <= max_samples; ++j) {
    const float off = static_cast<float>(j) * spacing_ / window;
    preference[static_cast<std::size_t>(j + half)] = std::max(0.0F, 1 - 0.7F * off * off);
  }
  strength_.fill(0);
  if (half > max_samples) return;
  for (int i = 0; i < rays; i += span_.every) {
    const auto ray = static_cast<std::size_t>(i);
    const float expected = circle.r + circle.x * towards.x[ray] + circle.y * towards.y[ray];
    const int middle = static_cast<int>((expected - first_) * per_sample + 0.5F);
    const int from = std::max(span_.reach + 1, middle - half),
              to = std::min(known_[ray] - span_.reach - 2, middle + half);
    const auto& step = step_[ray];
    float best = 0;
    int best_at = -1;
    for (int k = from; k <= to; ++k) {
      const float value =
          sign * step[static_cast<std::size_t>(k)] * preference[static_cast<std::size_t>(k - middle + half)];
      if (value > best) best = value, best_at = k;
    }
    if (best_at < 0) continue;
    const auto at = static_cast<std::size_t>(best_at);
    const float here = sign * step[at], before = sign * step[at - 1], after = sign * step[at + 1];
    if (here < min_step) continue;
    const float bend = before - 2 * here + after;
    const float shift = bend < 0 ? std::clamp(0.5F * (before - after) / bend, -1.0F, 1.0F) : 0.0F;
    edge_[ray] = first_ + (static_cast<float>(best_at) + shift) * spacing_;
    strength_[ray] = here;
  }
}

// One step of least squares with weights that let go of what lies off the circle by more than `scale`.
bool CircleFitter::adjust(Fitted& circle, float scale) const {
  constexpr int lanes = 8;  // sums in parallel, always in the same order
  std::array<std::array<float, lanes>, 9> sums{};
  const float inverse = 1 / scale;
  for (std::size_t i = 0; i < rays; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const std::size_t ray = i + lane;
      const float ux = towards.x[ray], uy = towards.y[ray];
      const float off = edge_[ray] - (circle.r + circle.x * ux + circle.y * uy), part = off * inverse;
      const float keep = std::max(0.0F, 1 - part * part), strength = std::min(strength_[ray], 60.0F),
                  weight = keep * keep * strength;
      const float wx = weight * ux, wy = weight * uy;
      sums[0][lane] += weight, sums[1][lane] += wx, sums[2][lane] += wy;
      sums[3][lane] += wx * ux, sums[4][lane] += wx * uy, sums[5][lane] += wy * uy;
      sums[6][lane] += weight * off, sums[7][lane] += wx * off, sums[8][lane] += wy * off;
    }
  std::array<double, 9> s{};
  for (std::size_t q = 0; q < 9; ++q)
    for (std::size_t lane = 0; lane < lanes; ++lane) s[q] += static_cast<double>(sums[q][lane]);
  // A little stiffness keeps a circle that is seen from one side only where it was.
  const double stiff = 0.01 * s[0] + 1e-9, a = s[0], b = s[1], c = s[2], d = s[3] + stiff, e = s[4], f = s[5] + stiff;
  const double det = a * (d * f - e * e) - b * (b * f - e * c) + c * (b * e - d * c);
  if (!(det > 1e-9)) return false;
  circle.r +=
      static_cast<float>((s[6] * (d * f - e * e) - b * (s[7] * f - e * s[8]) + c * (s[7] * e - d * s[8])) / det);
  circle.x +=
      static_cast<float>((a * (s[7] * f - e * s[8]) - s[6] * (b * f - e * c) + c * (b * s[8] - s[7] * c)) / det);
  circle.y +=
      static_cast<float>((a * (d * s[8] - s[7] * e) - b * (b * s[8] - s[7] * c) + s[6] * (b * e - d * c)) / det);
  return true;
}

CircleFitter::Fitted CircleFitter::fit_circle(double r, bool darker, double min_step,
                                              std::initializer_list<double> windows) {
  Fitted fitted{0, 0, static_cast<float>(r), false};
  for (const double part : windows) {
    const float window = static_cast<float>(part * r);
    find_edges(fitted, window, darker, static_cast<float>(min_step));
    const auto edges = std::count_if(strength_.begin(), strength_.end(), [](float strength) { return strength > 0; });
    if (edges < rays / span_.every / 3) return fitted;
    for (int turn = 0; turn < 2; ++turn)
      if (!adjust(fitted, std::max(0.6F * window, 0.5F))) return fitted;
    if (fitted.r < 0.55 * r || fitted.r > 1.45 * r || std::hypot(fitted.x, fitted.y) > 0.5F * static_cast<float>(r))
      return fitted;
  }
  fitted.good = true;
  return fitted;
}

void CircleFitter::judge(double x, double y, const Fitted& fitted, bool darker, double min_step,
                         CircleFit& circle_fit) const {
  const float sign = darker ? 1.0F : -1.0F;
  const float near = std::max(0.05F * fitted.r, 0.6F);
  const int reach = span_.reach;
  int inside = 0, on = 0;
  std::array<float, rays> steps{}, offs{};
  int offs_count = 0;
  std::array<int, 8> eighth_inside{}, eighth_on{};
  for (int i = 0; i < rays; ++i) {
    const auto ray = static_cast<std::size_t>(i);
    const float expected = fitted.r + fitted.x * towards.x[ray] + fitted.y * towards.y[ray];
    const int at = static_cast<int>(std::lround((expected - first_) / spacing_));
    if (at + reach + 1 >= known_[ray] || at < reach) continue;
    ++eighth_inside[ray / (rays / 8)];
    steps[static_cast<std::size_t>(inside++)] = sign * step_[ray][static_cast<std::size_t>(at)];
    if (strength_[ray] <= 0) continue;
    const float off = std::abs(edge_[ray] - expected);
    offs[static_cast<std::size_t>(offs_count++)] = off;
    if (off <= near && strength_[ray] >= static_cast<float>(min_step)) ++on, ++eighth_on[ray / (rays / 8)];
  }
  std::array<float, 8> eighths;
  eighths.fill(2);  // those outside the picture come last
  std::size_t eighths_seen = 0;
  for (std::size_t i = 0; i < 8; ++i)
    if (eighth_inside[i] >= 3)
      eighths[i] = static_cast<float>(eighth_on[i]) / static_cast<float>(eighth_inside[i]), ++eighths_seen;
  std::partial_sort(eighths.begin(), eighths.begin() + 3, eighths.end());
  const std::size_t least = std::max<std::size_t>(1, eighths_seen * 3 / 8);
  for (std::size_t i = 0; i < least; ++i) circle_fit.closed += std::min(eighths[i], 1.0F) / static_cast<float>(least);
  circle_fit.inside = static_cast<float>(inside) / rays;
  circle_fit.support = inside ? static_cast<float>(on) / static_cast<float>(inside) : 0;
  if (inside) {
    std::nth_element(steps.begin(), steps.begin() + inside / 2, steps.begin() + inside);
    circle_fit.contrast = steps[static_cast<std::size_t>(inside / 2)];
  }
  if (offs_count) {
    std::nth_element(offs.begin(), offs.begin() + offs_count / 2, offs.begin() + offs_count);
    circle_fit.scatter = offs[static_cast<std::size_t>(offs_count / 2)] / fitted.r;
  }
  circle_fit.profile =
      radial_profile(patch_, static_cast<float>(x) + fitted.x, static_cast<float>(y) + fitted.y, fitted.r);
}

std::optional<Circle> CircleFitter::roughly(const DownsampledImage& picture, const Circle& guess, bool darker,
                                            double noise) {
  const double x = picture.image_x(guess.x_px), y = picture.image_y(guess.y_px), r = guess.r_px / picture.block;
  const double min_step = std::max(3.0, 1.5 * noise / picture.block);
  sample(picture, x, y, r, {.from = 0.58, .to = 1.42, .samples = 28, .reach = 2, .every = 2});
  const Fitted found = fit_circle(r, darker, min_step, {0.32, 0.22, 0.16});
  if (!found.good) return {};
  // Generously: half of what will be asked of a robot.
  int on = 0, inside = 0;
  for (std::size_t ray = 0; ray < rays; ray += 2) {
    if (known_[ray] < span_.samples) continue;
    ++inside;
    if (strength_[ray] > 0 &&
        std::abs(edge_[ray] - (found.r + found.x * towards.x[ray] + found.y * towards.y[ray])) < 0.1F * found.r + 0.3F)
      ++on;
  }
  if (inside >= 8 && on * 100 < inside * 45) return {};
  return Circle{picture.picture_x(x + static_cast<double>(found.x)),
                picture.picture_y(y + static_cast<double>(found.y)), static_cast<double>(found.r) * picture.block};
}

std::optional<CircleFit> CircleFitter::fit(const cv::Mat& bgr, const Circle& guess, double off, bool darker,
                                           double noise) {
  // Large robots are looked at smaller: the cost of a fit does not depend on the size, and noise is averaged.
  const int block = std::max(1, static_cast<int>(guess.r_px / 14));
  const double far = (1.32 + 0.5 * off) * guess.r_px + 2;
  patch_.take(bgr, static_cast<int>(std::floor(guess.x_px - far)), static_cast<int>(std::floor(guess.y_px - far)),
              static_cast<int>(std::ceil(guess.x_px + far)) + 1, static_cast<int>(std::ceil(guess.y_px + far)) + 1,
              block);
  if (patch_.width < 4 || patch_.height < 4) return {};
  const double x = patch_.image_x(guess.x_px), y = patch_.image_y(guess.y_px), r = guess.r_px / block;
  const double min_step = std::max(3.0, 1.5 * noise / block);
  const double span = 0.14 + off;
  sample(patch_, x, y, r,
         {.from = 1 - span,
          .to = 1 + span,
          .samples = std::min(max_samples, static_cast<int>(span * 94)),
          .reach = 3,
          .every = 1});
  const Fitted found = off > 0.15 ? fit_circle(r, darker, min_step, {off, 0.12, 0.07})
                                  : fit_circle(r, darker, min_step, {0.14, 0.09, 0.07});
  if (!found.good) return {};
  CircleFit circle_fit;
  circle_fit.darker = darker;
  judge(x, y, found, darker, min_step, circle_fit);
  circle_fit.circle = {patch_.picture_x(x + static_cast<double>(found.x)),
                       patch_.picture_y(y + static_cast<double>(found.y)), static_cast<double>(found.r) * block};
  return circle_fit;
}

}  // namespace arkmesh::tracker
