// Pictures of real robots with what is known to be on them, how detections are scored, and new pictures made from them.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tracker/detect/detection.hpp"

namespace arkmesh::tests {

struct TrueRobot {
  double x_px = 0, y_px = 0, r_px = 0;
  hal::Led led = hal::Led::off;
  double led_x_px = 0, led_y_px = 0;  // not a number when the LED is off
};

struct Scene {
  std::string name;
  cv::Mat bgr;
  std::vector<TrueRobot> robots;
  std::vector<TrueRobot> also = {};  // cut by the picture's border: not asked for, and not wrong
};

hal::Led led_named(const std::string& name);

// The pictures of tests/data/kilobot-images: six, with 6 or 28 robots each.
std::vector<Scene> real_scenes();

// The same scene `factor` times as large: cubic when enlarged, area averages when shrunk.
Scene resized(const Scene& scene, double factor);
// So that the mean robot has this diameter.
Scene with_diameter(const Scene& scene, double diameter_px);

// A detection belongs to the nearest robot within half its radius, each to one at most (greedily by distance).
struct Score {
  int robots = 0, detections = 0, matched = 0;
  int colours_right = 0, leds_lit = 0, leds_found = 0;
  int leds_unknown = 0, leds_right = 0;  // of the lit ones
  double off_confidences = 0;            // squared differences of confidences from the truth, 1 or 0, summed
  double off_colours = 0;                // the same of colours that are told, of matched robots
  int colours_told = 0;
  double centre_error_px = 0, radius_error_px = 0;  // means over the matched
  double heading_error_deg = 0;                     // median over robots whose LED is lit and was found
  std::vector<double> heading_errors_deg;
  std::vector<int> robot_of;  // of each detection, or -1

  double precision() const { return detections ? static_cast<double>(matched) / detections : 1.0; }
  double recall() const { return robots ? static_cast<double>(matched) / robots : 1.0; }
  double colours() const { return matched ? static_cast<double>(colours_right) / matched : 1.0; }
  // Brier scores: 0 is best, 0.25 what a constant confidence of one half has.
  double brier() const { return detections ? off_confidences / detections : 0.0; }
  double brier_of_colours() const { return colours_told ? off_colours / colours_told : 0.0; }
};
Score score(const std::vector<tracker::Detection>& found, const std::vector<TrueRobot>& robots);
// Without detections of what is not asked for.
Score score(std::vector<tracker::Detection> found, const Scene& scene);
// Sums of several scores; means weighted by the robots.
Score total(const std::vector<Score>& scores);
// "precision 1.000 recall 1.000 centre 0.51 px colour 100 % heading 2.1 deg"
std::string text(const Score& score);

}  // namespace arkmesh::tests
