// Watches whether a camera still hangs where it was calibrated: follows a few dozen marks of the table (corners,
// specks, edges of what lies about) from picture to picture. Knows no robots; what covers a mark hides it, that is all.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "tracker/calibration.hpp"
#include "tracker/circle.hpp"

namespace arkmesh::tracker {

struct GuardSettings {
  double tolerance_m = 0.0015;  // marks that are on the whole nearer than this to their places are in place
  double tolerance_px = 0.7;    // but so much is always allowed
  double min_seen =
      0.25;  // a picture that shows fewer of the marks than this part is not of that table, or there is no light
  int patience = 10;  // pictures between attempts to find out where the camera hangs now
};

class CameraGuard {
 public:
  enum class Verdict : std::uint8_t {
    in_place,      // or there are too few marks to know
    moved,         // the picture shows the table from elsewhere: places in it are wrong
    unrecognised,  // too few marks are seen: dark, covered, or moved far
  };

  explicit CameraGuard(const GuardSettings& settings = {}) : settings_(settings) {}

  // The first picture teaches what the table looks like from where the camera was calibrated; `robots` are circles in
  // it that are no marks. Later ones are compared with it. Pictures are 8-bit BGR, all of one size. Takes a fraction of
  // a millisecond, the first one and those in which the camera is moved longer.
  void learn(const cv::Mat& bgr, std::span<const Circle> robots, const Calibration& calibration);
  bool has_learnt() const { return learnt_; }
  Verdict look(const cv::Mat& bgr, const Calibration& calibration);
  // Where the camera hangs now, once two attempts `patience` pictures apart agree on it; else nothing. Marks are in
  // place again with that.
  std::optional<Calibration> realigned();

  std::size_t marks() const { return marks_.size(); }
  // How far marks were from their places in the last picture: median, of those that were seen.
  double off_px() const { return off_px_; }

 private:
  struct Mark {
    double x_px = 0, y_px = 0;          // where it was when it was learnt: where its template is centred
    double at_x_px = 0, at_y_px = 0;    // where it belongs by the calibration of now
    double off_x_px = 0, off_y_px = 0;  // where it was last seen, from there
    bool seen = false;
    Point on_table;                             // metres
    std::vector<float> grey, along_x, along_y;  // the template, without its mean, and its slopes
    double energy = 0, xx = 0, xy = 0, yy = 0, sigma_px = 0;
  };

  bool find(Mark& mark, const cv::Mat& bgr, double x_px, double y_px, double within_px) const;
  void search(const cv::Mat& bgr);
  std::optional<Calibration> fit(const Calibration& from) const;

  GuardSettings settings_;
  bool learnt_ = false;
  std::vector<Mark> marks_;
  cv::Mat small_;  // the first picture, shrunk and grey
  int shrunk_ = 1;
  double off_px_ = 0;
  std::size_t turn_ = 0;
  int amiss_ = 0;  // pictures in a row
  std::optional<Calibration> tried_, found_;
};

}  // namespace arkmesh::tracker
