// What an emulator looks like apart from its robots: floor, walls, light, and things that lie about. Drawn once for
// each camera.
#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "emulator/camera_model.hpp"
#include "hal/config/config.hpp"
#include "hal/platforms/kilobot/body.hpp"

namespace arkmesh::emulator {

struct Scene {
  double width_m = 1, height_m = 1;  // of the arena
  double arena_grey = 165;           // of 255, where the light is 1
  double texture = 0.03;             // contrast of the mottled arena surface
  double wall_m = 0.012;             // width of the frame around the arena
  double wall_grey = 125;            // of 255; robots are about 40
  double light_slope = 0.2;          // how much brighter the arena is on the lamp's side than in its middle
  double light_from_rad = 2.2;       // direction of the lamp, from +x; shadows fall away from it
  double shadow = 0.4;               // share of light that a robot blocks from the arena below it
  double cell_brightness = 1;        // of coin cells: 0.2 is black, 1 steel, 3 blown out to white
  double cell_radius = 0.715;        // of coin cells, of a robot's radius
  double glare = 0;                  // 0..1: the lamp, mirrored by each robot on the lamp's side
  double domes = 0;                  // 0..1: the lamp, mirrored by unlit LEDs
  bool distractors = false;          // paper, cables, a round board, a pen: around the arena, stickers in it
  double robot_height_m = hal::kilobot::board_height_m;  // of what cameras look for; cells lie 7 mm higher
  double body_radius_m = hal::kilobot::body_radius_m;
  std::vector<hal::RobotId> markers;  // the numbers of the robots' markers; empty: robots look as Kilobots do
  std::string marker_family = "apriltag_36h11";
  double marker_m = 0.05;  // side of the black square
  std::uint64_t seed = 1;

  // Keys of [emulator.scene].
  double light_from_deg = 126, stated_height_m = std::numeric_limits<double>::quiet_NaN();
  void fields(const hal::Section& scene);

  // 1 in the arena's middle.
  double light_at(double x_m, double y_m) const;
};

// The empty arena as that camera sees it, without noise and blur; `vignetting` is the share of light lost in the
// corners.
cv::Mat draw_scene(const Scene& scene, const CameraModel& camera, double vignetting);
// Share of the light that reaches a pixel.
double vignetting_at(const CameraModel& camera, double vignetting, double x_px, double y_px);

// A picture of a chessboard held before the camera; `number` chooses among many poses, all wholly in view.
// Inner corners `columns` x `rows`.
cv::Mat draw_chessboard(const CameraModel& camera, int columns, int rows, double square_m, std::uint64_t number,
                        std::uint64_t seed);

}  // namespace arkmesh::emulator
