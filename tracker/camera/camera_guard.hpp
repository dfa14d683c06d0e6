// Watches whether a camera still hangs where it was calibrated: looks for a few dozen landmarks of the arena in each
// picture. Knows no robots; what covers a mark hides it, that is all.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "tracker/camera/calibration.hpp"
#include "tracker/camera/landmarks.hpp"

namespace arkmesh::tracker {

struct GuardSettings {
  double tolerance_m = 0.0015;  // marks that are on the whole nearer than this to their places are in place
  double tolerance_px = 0.7;    // but so much is always allowed
  double min_seen =
      0.25;  // a picture that shows fewer of the marks than this part is not of that arena, or there is no light
  int patience = 10;  // pictures between attempts to find out where the camera hangs now
};

class CameraGuard {
 public:
  enum class Verdict : std::uint8_t {
    in_place,      // or there are too few marks to know
    moved,         // the picture shows the arena from elsewhere: places in it are wrong
    unrecognised,  // too few marks are seen: dark, covered, or moved far
  };

  explicit CameraGuard(const GuardSettings& settings = {}) : settings_(settings) {}

  // Fewer marks tell nothing.
  static constexpr std::size_t fewest_marks = 8;

  // What the arena looks like from where the camera was calibrated: landmarks of a picture that fits `calibration`,
  // and of the size that it is for. Later pictures are compared with it, which takes a fraction of a millisecond, for
  // the first one and those in which the camera is moved longer. They are 8-bit BGR and of that size, too.
  void learn(std::span<const Landmark> landmarks, const Calibration& calibration);
  bool has_learnt() const { return learnt_; }
  Verdict look(const cv::Mat& bgr, const Calibration& calibration);
  // Where the camera hangs now, once two attempts `patience` pictures apart agree on it; else nothing. Marks are in
  // place again with that.
  std::optional<Calibration> realigned();

  std::size_t marks() const { return marks_.size(); }
  // How far marks were from their places in the last picture: median, of those that were seen.
  double off_px() const { return off_px_; }
  // Which part of the marks the last picture showed in which all of them were looked for, as in the first.
  double seen_part() const { return seen_part_; }

 private:
  struct Mark {
    double x_px = 0, y_px = 0;          // where it was when it was learnt: where its template is centred
    double at_x_px = 0, at_y_px = 0;    // where it belongs by the calibration of now
    double off_x_px = 0, off_y_px = 0;  // where it was last seen, from there
    bool seen = false;
    Point on_arena;  // metres
    Template look;
    cv::Mat rough;
  };

  bool find(Mark& mark, const cv::Mat& bgr, double x_px, double y_px, double within_px) const;
  bool search(const cv::Mat& bgr, double max_px);
  std::optional<Calibration> fit(const Calibration& from) const;

  GuardSettings settings_;
  bool learnt_ = false, confirmed_ = false;  // confirmed: was seen in place since
  std::vector<Mark> marks_;
  int rough_block_ = 1;
  double off_px_ = 0, seen_part_ = 0;
  std::size_t turn_ = 0;
  int amiss_ = 0;  // pictures in a row
  std::optional<Calibration> tried_, found_;
};

}  // namespace arkmesh::tracker
