// Draws what a scenario shows people (hal/drawing) over a camera's picture, where it would lie on the arena.
#pragma once

#include "hal/overlay/drawing.hpp"
#include "tracker/camera/calibration.hpp"

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

// Into `picture` (8-bit BGR), in the colours for dark grounds. What the camera cannot see is left out, and so are fills
// after 16 times the picture's area and outlines after a million pixels.
void draw_overlay(cv::Mat& picture, const Calibration& camera, const hal::Drawing& drawing);

}  // namespace arkmesh::tracker
