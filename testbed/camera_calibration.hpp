// What `arkmesh calibrate` shows people of a camera's calibration, and the file that holds those of a testbed.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tracker/camera/calibration_file.hpp"

namespace arkmesh::testbed {

// The arena's outline and a grid of tenths over the picture, so that one sees whether it lies on the arena.
void draw_arena(cv::Mat& picture, const tracker::CameraData& camera);

// Whether robots are large enough in the picture is what people can still change. Nothing where the camera does not
// look.
std::optional<double> robot_width_px(const tracker::CameraData& camera, tracker::Point at);

// Landmarks by which a lab notices that the camera was moved since. The robots that the picture shows hold none.
std::vector<tracker::Landmark> landmarks_of(const cv::Mat& picture, const tracker::CameraData& camera);

// Adds the camera to those of the file, or takes the place of its namesake. Returns how many it holds then. Throws
// std::runtime_error with one sentence.
std::size_t put_into(const std::filesystem::path& file, const tracker::NamedCamera& camera);

}  // namespace arkmesh::testbed
