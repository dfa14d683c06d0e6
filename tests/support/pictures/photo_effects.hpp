// What light, lens, sensor, compression and the photographer's hand do to a picture, one at a time.
#pragma once

#include <functional>

#include "tests/support/pictures/robot_pictures.hpp"

namespace arkmesh::tests {

// In place, on 8-bit BGR.
void apply_gamma(cv::Mat& bgr, double gamma);
void expose(cv::Mat& bgr, double stops);                         // in linear light, cut off at white
void cast(cv::Mat& bgr, double blue, double green, double red);  // gains in linear light: a wrong white balance
void multiply_by(cv::Mat& bgr,
                 const std::function<double(double, double)>& gain);  // gain(x, y), both 0..1 over the picture
void vignette(cv::Mat& bgr, double corner);                           // 1 in the middle, this much in the corners
void add_noise(cv::Mat& bgr, double deviation, unsigned seed);
void add_salt(cv::Mat& bgr, double part, unsigned seed);  // this part of the pixels becomes black or white
void compress(cv::Mat& bgr, int quality);
void motion_blur(cv::Mat& bgr, double length_px, double angle_deg);
void turn_hue(cv::Mat& bgr, int half_degrees);

// Gives every so many-th robot with a blue LED another colour: the light its LED adds to a channel is moved to the
// channels of that colour.
Scene recoloured(const Scene& scene, hal::Led led, std::size_t every = 1);
// A lamp mirrored in all coin cells: so many grey levels brighter in the middle, and none at 0.6 of the robot's radius.
Scene with_glare(const Scene& scene, double levels);

Scene changed(const Scene& scene, const std::function<void(cv::Mat&)>& change);

// Moves all pixels and all that is known by a 3 x 3 matrix. What leaves the picture in part is only in `also`. Beyond
// the border the picture goes on as at its edge, or black.
Scene warped(const Scene& scene, const cv::Matx33d& move, cv::Size size, bool black_border = false);
Scene turned(const Scene& scene, double angle_deg, bool black_border);
Scene mirrored(const Scene& scene);
// Robots wholly inside are asked for; with `visible_part`, those of whose diameter at least this part is inside.
Scene cropped(const Scene& scene, const cv::Rect& part, double visible_part = 1.0);
// `count` cut-outs of the scenes that hold exactly so many whole robots.
std::vector<Scene> cut_outs(const std::vector<Scene>& scenes, int robots, int count, unsigned seed);
// Cut-outs whose borders cut robots.
std::vector<Scene> border_cuts(const std::vector<Scene>& scenes, double visible_part, int count, unsigned seed);

}  // namespace arkmesh::tests
