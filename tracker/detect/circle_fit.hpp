// The outer edge of one robot to a fraction of a pixel: edges along rays from a first guess, and the circle that most
// of them agree on.
#pragma once

#include <array>
#include <initializer_list>
#include <optional>
#include <vector>

#include "tracker/detect/circle.hpp"
#include "tracker/detect/downsampled_image.hpp"
#include "tracker/detect/radial_profile.hpp"

namespace arkmesh::tracker {

struct CircleFit {
  Circle circle;
  bool darker = true;     // than what surrounds it
  float support = 0;      // part of the rays inside the picture whose edge lies on the circle
  float closed = 0;       // the same in the three eighths of the turn where it is least: low for cables and corners
  float inside = 0;       // part of the rays whose edge would lie inside the picture
  float contrast = 0;     // median step over the edge, in grey levels
  float scatter = 0;      // of the edges round the circle, as a part of its radius (median deviation)
  RadialProfile profile;  // what it encloses
};

// Keeps its working memory from call to call.
class CircleFitter {
 public:
  // A better guess from a picture downsampled so that the robot's radius is 5 to 12 of its pixels: the first one may be
  // off by a third of its radius in place and in size. `noise` is that of the whole picture, in grey levels. Empty when
  // too few edges agree on any circle.
  std::optional<Circle> roughly(const DownsampledImage& picture, const Circle& guess, bool darker, double noise);
  // From the picture itself; `guess` may be off by the given part of its radius.
  std::optional<CircleFit> fit(const cv::Mat& bgr, const Circle& guess, double off, bool darker, double noise);

 private:
  static constexpr int rays = 48, max_samples = 40;
  // Where along a ray grey levels are taken: parts of the radius.
  struct Span {
    double from, to;
    int samples, reach;  // reach: samples on either side of an edge that make its step
    int every;           // only each such ray
  };
  struct Fitted {
    float x = 0, y = 0, r = 0;  // relative to the origin of the rays, in pixels of the patch
    bool good = false;
  };
  void sample(const DownsampledImage& picture, double x, double y, double r, const Span& span);
  void find_edges(const Fitted& circle, float window, bool darker, float min_step);
  bool adjust(Fitted& circle, float scale) const;
  Fitted fit_circle(double r, bool darker, double min_step, std::initializer_list<double> windows);
  void judge(double x, double y, const Fitted& fitted, bool darker, double min_step, CircleFit& circle_fit) const;

  DownsampledImage patch_;
  Span span_{};
  std::array<std::array<float, max_samples>, rays> step_{};  // rise of the grey level outwards along each ray
  std::array<int, rays> known_{};                            // samples of the ray that lie inside the picture
  std::array<float, rays> edge_{};                           // distance of the chosen edge
  std::array<float, rays> strength_{};                       // its step; 0 when there is none
  float first_ = 0, spacing_ = 0;                            // of the samples along a ray, in pixels of the patch
};

}  // namespace arkmesh::tracker
