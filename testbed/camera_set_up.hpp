// The steps of calibrating a camera: a lens from pictures of a chessboard, the arena's corners on a picture of the
// table, a picture to check by eye, and the camera's place in a calibration file. Each throws std::runtime_error with
// one sentence.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tracker/calibration_file.hpp"
#include "tracker/camera_fit.hpp"

namespace arkmesh::testbed {

// `looked` hears of each picture whether a whole chessboard was found on it.
tracker::FittedLens fit_lens(const std::vector<std::string>& pictures, const tracker::ChessboardSize& board,
                             const std::function<void(const std::string& picture, bool found)>& looked);

// Where `picture`, taken with `lens`, shows the arena's corners, from the upper left one clockwise.
std::vector<tracker::Point> find_corners(const std::string& picture, const tracker::Lens& lens);

// The arena's outline and a grid of tenths over `picture`, so that one sees whether it lies on the table; over grey
// when `picture` is empty.
void draw_arena(const std::string& png, const std::string& picture, const tracker::CameraData& camera);

// How wide a robot is in the picture when it stands there, pixels; whether robots are large enough is what people can
// still change. Empty where the camera does not see.
std::optional<double> robot_width_px(const tracker::CameraData& camera, tracker::Point at);

// Adds the camera to those of the file, or takes the place of its namesake. Returns how many the file holds.
std::size_t keep_camera(const std::filesystem::path& file, const tracker::NamedCamera& camera);

}  // namespace arkmesh::testbed
