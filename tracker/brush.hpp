// Strokes on a camera's picture in fractions of a pixel, and words that can be read on every arena.
#pragma once

#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tracker/camera/calibration.hpp"

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

inline constexpr int fine_shift = 4;  // lines to a sixteenth of a pixel: the `shift` of OpenCV's functions

// As OpenCV takes it with fine_shift; nothing when `at` is none, or so far outside that nothing is to be drawn.
std::optional<cv::Point> fine(const std::optional<Point>& at);
// A circle of the arena as the camera sees it, in such points; empty where the camera cannot look.
std::vector<cv::Point> ring(const Calibration& camera, Point centre, double radius_m, double height_m);
// With a dark edge. `at`: the left end of the line that the words stand on.
void write(cv::Mat& picture, const std::string& text, Point at, double size_px, const cv::Scalar& colour);
// The same with its middle at `at`.
void write_centred(cv::Mat& picture, const std::string& text, Point at, double size_px, const cv::Scalar& colour);

}  // namespace arkmesh::tracker
