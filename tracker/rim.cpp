// See rim.hpp.
#include "tracker/rim.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace arkmesh::tracker {
namespace {

constexpr double tau = 6.283185307179586;
constexpr double nearest_part = 0.58, farthest_part = 1.42;  // of the radius: where a ray is sampled
constexpr int reach = 3;                                     // samples on either side that make a step

struct Directions {
  std::array<double, 64> x{}, y{};
  Directions() {
    for (int i = 0; i < 64; ++i) {
      x[static_cast<std::size_t>(i)] = std::cos(tau * i / 64);
      y[static_cast<std::size_t>(i)] = std::sin(tau * i / 64);
    }
  }
};
const Directions& directions() {
  static const Directions table;
  return table;
}

float between(const ShrunkPicture& patch, float x, float y) {
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
  const std::int16_t* upper = patch.row(iy) + ix;
  const std::int16_t* lower = upper + patch.width;
  const float top = static_cast<float>(upper[0]) + fx * static_cast<float>(upper[1] - upper[0]);
  const float bottom = static_cast<float>(lower[0]) + fx * static_cast<float>(lower[1] - lower[0]);
  return (top + fy * (bottom - top)) * 0.125F;
}

}  // namespace

void RimFinder::sample(double x, double y, double r, int every) {
  first_ = nearest_part * r;
  spacing_ = (farthest_part - nearest_part) * r / (samples - 1);
  const float most_x = static_cast<float>(patch_.width) - 1.001F, most_y = static_cast<float>(patch_.height) - 1.001F;
  for (int i = 0; i < rays; i += every) {
    const auto ray = static_cast<std::size_t>(i);
    const double ux = directions().x[ray], uy = directions().y[ray];
    auto& along = along_[ray];
    auto& step = step_[ray];
    int known = 0;
    float px = static_cast<float>(x + first_ * ux), py = static_cast<float>(y + first_ * uy);
    const float dx = static_cast<float>(spacing_ * ux), dy = static_cast<float>(spacing_ * uy);
    for (; known < samples; ++known, px += dx, py += dy) {
      if (!(px >= 0 && py >= 0 && px <= most_x && py <= most_y)) break;
      along[static_cast<std::size_t>(known)] = between(patch_, px, py);
    }
    known_[ray] = known;
    step.fill(0);
    if (known < 2 * reach + 1) continue;
    float outer = 0, inner = 0;
    for (int k = 0; k < reach; ++k) inner += along[static_cast<std::size_t>(k)], outer += along[static_cast<std::size_t>(reach + 1 + k)];
    for (int k = reach;; ++k) {
      step[static_cast<std::size_t>(k)] = (outer - inner) / reach;
      if (k + reach + 1 >= known) break;
      const auto at = static_cast<std::size_t>(k);
      outer += along[at + reach + 1] - along[at + 1];
      inner += along[at] - along[at - reach];
    }
  }
}

RimFinder::Fitted RimFinder::fit_circle(double r, bool darker, double least_step, int every, const double* windows, int turns) {
  Fitted fitted{0, 0, r, false};
  const float sign = darker ? 1.0F : -1.0F;
  for (int turn = 0; turn < turns; ++turn) {
    const double window = windows[turn] * r;
    int edges = 0;
    for (int i = 0; i < rays; i += every) {
      const auto ray = static_cast<std::size_t>(i);
      edge_[ray] = -1;
      const double expected = fitted.r + fitted.x * directions().x[ray] + fitted.y * directions().y[ray];
      const int from = std::max(reach + 1, static_cast<int>((expected - window - first_) / spacing_));
      const int to = std::min(known_[ray] - reach - 2, static_cast<int>((expected + window - first_) / spacing_) + 1);
      float best = 0;
      int best_at = -1;
      for (int k = from; k <= to; ++k) {
        const double off = (first_ + k * spacing_ - expected) / window;
        const float value = sign * step_[ray][static_cast<std::size_t>(k)] * static_cast<float>(std::max(0.0, 1 - 0.7 * off * off));
        if (value > best) best = value, best_at = k;
      }
      if (best_at < 0) continue;
      const auto at = static_cast<std::size_t>(best_at);
      const float here = sign * step_[ray][at], before = sign * step_[ray][at - 1], after = sign * step_[ray][at + 1];
      if (here < static_cast<float>(least_step)) continue;
      const float bend = before - 2 * here + after;
      const float shift = bend < 0 ? std::clamp(0.5F * (before - after) / bend, -1.0F, 1.0F) : 0.0F;
      edge_[ray] = first_ + (best_at + static_cast<double>(shift)) * spacing_;
      strength_[ray] = here;
      ++edges;
    }
    if (edges < rays / every / 4) return fitted;
    // Gauss-Newton with weights that let go of what lies off the circle.
    const double scale = std::max(0.6 * window, 0.5);
    for (int step = 0; step < 3; ++step) {
      double a00 = 0, a01 = 0, a02 = 0, a11 = 0, a12 = 0, a22 = 0, b0 = 0, b1 = 0, b2 = 0;
      for (int i = 0; i < rays; i += every) {
        const auto ray = static_cast<std::size_t>(i);
        if (edge_[ray] < 0) continue;
        const double ux = directions().x[ray], uy = directions().y[ray];
        const double off = edge_[ray] - (fitted.r + fitted.x * ux + fitted.y * uy), part = off / scale;
        if (part * part >= 1) continue;
        const double weight = (1 - part * part) * (1 - part * part) * std::min<double>(strength_[ray], 60.0);
        a00 += weight, a01 += weight * ux, a02 += weight * uy;
        a11 += weight * ux * ux, a12 += weight * ux * uy, a22 += weight * uy * uy;
        b0 += weight * off, b1 += weight * off * ux, b2 += weight * off * uy;
      }
      // A little stiffness keeps a circle that is seen from one side only where it was.
      const double stiff = 0.01 * a00 + 1e-9;
      a11 += stiff, a22 += stiff;
      const double det = a00 * (a11 * a22 - a12 * a12) - a01 * (a01 * a22 - a12 * a02) + a02 * (a01 * a12 - a11 * a02);
      if (!(det > 1e-9)) return fitted;
      const double dr = (b0 * (a11 * a22 - a12 * a12) - a01 * (b1 * a22 - a12 * b2) + a02 * (b1 * a12 - a11 * b2)) / det;
      const double dx = (a00 * (b1 * a22 - a12 * b2) - b0 * (a01 * a22 - a12 * a02) + a02 * (a01 * b2 - b1 * a02)) / det;
      const double dy = (a00 * (a11 * b2 - b1 * a12) - a01 * (a01 * b2 - b1 * a02) + b0 * (a01 * a12 - a11 * a02)) / det;
      fitted.r += dr, fitted.x += dx, fitted.y += dy;
    }
    if (fitted.r < 0.55 * r || fitted.r > 1.45 * r || std::hypot(fitted.x, fitted.y) > 0.5 * r) return fitted;
  }
  fitted.good = true;
  return fitted;
}

void RimFinder::judge(double x, double y, const Fitted& fitted, bool darker, double least_step, Rim& rim) {
  const float sign = darker ? 1.0F : -1.0F;
  const double near = std::max(0.05 * fitted.r, 0.6);
  int inside = 0, on = 0;
  std::array<float, rays> steps{}, offs{};
  int offs_count = 0;
  std::array<int, 8> eighth_inside{}, eighth_on{};
  for (int i = 0; i < rays; ++i) {
    const auto ray = static_cast<std::size_t>(i);
    const double expected = fitted.r + fitted.x * directions().x[ray] + fitted.y * directions().y[ray];
    const int at = static_cast<int>(std::lround((expected - first_) / spacing_));
    if (at + reach + 1 >= known_[ray] || at < reach) continue;
    ++eighth_inside[ray / 8];
    steps[static_cast<std::size_t>(inside++)] = sign * step_[ray][static_cast<std::size_t>(at)];
    if (edge_[ray] < 0) continue;
    const double off = std::abs(edge_[ray] - expected);
    offs[static_cast<std::size_t>(offs_count++)] = static_cast<float>(off);
    if (off <= near && strength_[ray] >= static_cast<float>(least_step)) ++on, ++eighth_on[ray / 8];
  }
  std::array<float, 8> eighths;
  eighths.fill(2);  // those outside the picture come last
  std::size_t eighths_seen = 0;
  for (std::size_t i = 0; i < 8; ++i)
    if (eighth_inside[i] >= 4) eighths[i] = static_cast<float>(eighth_on[i]) / static_cast<float>(eighth_inside[i]), ++eighths_seen;
  std::partial_sort(eighths.begin(), eighths.begin() + 3, eighths.end());
  const std::size_t least = std::max<std::size_t>(1, eighths_seen * 3 / 8);
  for (std::size_t i = 0; i < least; ++i) rim.closed += std::min(eighths[i], 1.0F) / static_cast<float>(least);
  rim.inside = static_cast<float>(inside) / rays;
  rim.support = inside ? static_cast<float>(on) / static_cast<float>(inside) : 0;
  if (inside) {
    std::nth_element(steps.begin(), steps.begin() + inside / 2, steps.begin() + inside);
    rim.contrast = steps[static_cast<std::size_t>(inside / 2)];
  }
  if (offs_count) {
    std::nth_element(offs.begin(), offs.begin() + offs_count / 2, offs.begin() + offs_count);
    rim.scatter = offs[static_cast<std::size_t>(offs_count / 2)] / static_cast<float>(fitted.r);
  }
  // Grey level of rings round the centre, each looked at in 16 directions.
  const float most_x = static_cast<float>(patch_.width) - 1.001F, most_y = static_cast<float>(patch_.height) - 1.001F;
  std::array<float, 9 * 16> within{};
  std::size_t within_count = 0;
  for (std::size_t ring = 0; ring < rim.rings.size(); ++ring) {
    const double far = (0.1 * static_cast<double>(ring) + 0.05) * fitted.r;
    float sum = 0;
    int count = 0;
    for (std::size_t ray = ring % 2 ? 2 : 0; ray < static_cast<std::size_t>(rays); ray += 4) {
      const auto px = static_cast<float>(x + fitted.x + far * directions().x[ray]), py = static_cast<float>(y + fitted.y + far * directions().y[ray]);
      if (!(px >= 0 && py >= 0 && px <= most_x && py <= most_y)) continue;
      const float value = between(patch_, px, py);
      if (ring < 9) within[within_count++] = value;
      sum += value;
      ++count;
    }
    rim.rings[ring] = count ? sum / static_cast<float>(count) : 0;
  }
  if (within_count == 0) return;
  float mean = 0, deviation = 0;
  for (std::size_t i = 0; i < within_count; ++i) mean += within[i] / static_cast<float>(within_count);
  for (std::size_t i = 0; i < within_count; ++i) deviation += std::abs(within[i] - mean);
  rim.activity = deviation / static_cast<float>(within_count);
}

std::optional<Rim> RimFinder::fit(const cv::Mat& bgr, const Circle& guess, bool darker, double noise) {
  // Large robots are looked at smaller: the cost of a fit does not depend on the size, and noise is averaged.
  const int block = std::max(1, static_cast<int>(guess.r_px / 18));
  const double far = 1.9 * guess.r_px + 2;
  patch_.take(bgr, static_cast<int>(std::floor(guess.x_px - far)), static_cast<int>(std::floor(guess.y_px - far)),
              static_cast<int>(std::ceil(guess.x_px + far)) + 1, static_cast<int>(std::ceil(guess.y_px + far)) + 1, block);
  if (patch_.width < 4 || patch_.height < 4) return {};

  double x = patch_.shrunk_x(guess.x_px), y = patch_.shrunk_y(guess.y_px), r = guess.r_px / block;
  const double least_step = std::max(3.0, 1.5 * noise / block);
  constexpr double coarse[] = {0.32, 0.22, 0.16}, fine[] = {0.14, 0.10, 0.08, 0.07};
  sample(x, y, r, 2);
  const Fitted near = fit_circle(r, darker, least_step, 2, coarse, 3);
  if (!near.good) return {};
  x += near.x, y += near.y, r = near.r;
  sample(x, y, r, 1);
  const Fitted found = fit_circle(r, darker, least_step, 1, fine, 4);
  if (!found.good) return {};
  Rim rim;
  rim.darker = darker;
  judge(x, y, found, darker, least_step, rim);
  rim.circle = {patch_.picture_x(x + found.x), patch_.picture_y(y + found.y), found.r * block};
  return rim;
}

}  // namespace arkmesh::tracker
