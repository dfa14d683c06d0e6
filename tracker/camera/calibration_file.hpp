// Calibration files: OpenCV's YAML (or XML, or JSON), ours and ARK's. Every refusal names the file and says what to do.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tracker/camera/calibration.hpp"
#include "tracker/camera/landmarks.hpp"

namespace arkmesh::tracker {

struct NamedCamera {
  std::string name;
  CameraData data;
  std::vector<Landmark> landmarks = {};  // none: nobody can tell whether the camera was moved since
};

// One to sixteen cameras, in the file's order. Throws std::runtime_error with one sentence: not there, no calibration,
// not possible.
std::vector<NamedCamera> read_calibrations(const std::filesystem::path& file);
// The camera of that name; with an empty name the only one.
NamedCamera read_calibration(const std::filesystem::path& file, const std::string& name = {});
void write_calibrations(const std::filesystem::path& file, const std::vector<NamedCamera>& cameras);

// The lens that a calibration of OpenCV (YAML or XML) or ROS (camera_info YAML) tells of. Throws std::runtime_error
// with one sentence.
Lens read_intrinsics(const std::filesystem::path& file);

// What ARK's file does not hold.
struct ArkArena {
  int width_px = 2048, height_px = 1536;  // of the cameras' pictures
  int overview_px = 1536;                 // side of the stitched overview that the corners were clicked in
  double arena_width_m = 2, arena_height_m = 2;
  double camera_height_m = 1.6;  // above the arena; decides only how the robots' height is corrected
};

// The cameras of a calibration made for ARK's tracker (K and R lists, corner1 to corner4), in its order. Such a file
// knows no distortion and no place of the cameras; each is taken to hang above what is in the middle of its picture.
std::vector<CameraData> import_ark_calibration(const std::filesystem::path& file, const ArkArena& arena);

}  // namespace arkmesh::tracker
