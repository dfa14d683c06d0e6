// What was found on one picture, for people and programs: JSON, a table, circles and arrows on the picture. In pixels;
// knows no arena.
#pragma once

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tracker/detect/detection.hpp"
#include "tracker/detect/explanation.hpp"

namespace arkmesh::testbed {

// Angles in (-pi, pi], counter-clockwise from the picture's right; not a number when the LED is off.
double led_heading_rad(const tracker::Detection& robot);
double heading_rad(const tracker::Detection& robot, double led_offset_rad);

// A list of {x_px, y_px, r_px, led, led_x_px, led_y_px, heading_rad, led_heading_rad}; what an unlit LED leaves unknown
// is null.
nlohmann::json robots_as_json(const std::vector<tracker::Detection>& robots, double led_offset_rad);
std::string robots_as_text(const std::vector<tracker::Detection>& robots, double led_offset_rad);
// Which sizes were looked for in vain; `diameter_px` 0: none was told.
std::string nothing_found(double diameter_px);
cv::Mat with_robots_drawn(const cv::Mat& bgr, const std::vector<tracker::Detection>& robots, double led_offset_rad);

// Draws why: what was found, with rim, usual coin cell and where an LED can be; what nearly was, and what speaks
// against it; the evidence for the robots' size.
cv::Mat explained(const cv::Mat& bgr, const std::vector<tracker::Detection>& robots,
                  const tracker::Explanation& explanation);

}  // namespace arkmesh::testbed
