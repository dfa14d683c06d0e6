// Draws what is known over a camera's picture: robots' circles, names, headings and LEDs, and the arena's border. What
// scenarios draw is overlay_painter's.
#pragma once

#include <span>
#include <string>

#include "hal/types.hpp"
#include "tracker/camera/calibration.hpp"
#include "tracker/follow/track.hpp"
#include "tracker/follow/view_fusion.hpp"

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

// Draws into `picture` (8-bit BGR). A robot's circle has the colour of its LED (orange when off) and is thin while it
// is out of sight; its arrow is the driving direction, left out when that is not known. The text is the robot's id,
// with a question mark while it is doubtful, or #number of a track that nobody has named.
void draw_tracks(cv::Mat& picture, const Calibration& camera, std::span<const Track> tracks, const Body& body);
// Robots of other labs, where they are in this arena: circles of their LEDs' colours.
void draw_ghosts(cv::Mat& picture, const Calibration& camera, std::span<const hal::Observation> robots,
                 double radius_m);
// The arena's border: where it does not lie on the real one, the camera was moved or the calibration is
// another's.
void draw_border(cv::Mat& picture, const Calibration& camera);
// One line of text in the upper left corner.
void draw_caption(cv::Mat& picture, const std::string& text);

}  // namespace arkmesh::tracker
