// A film of Kilobots that walk on an emulated testbed, frame by frame, with the truth. The testbed, its cameras and the
// robots' ways are those of an emulator; the robots may be cut from real pictures, turned and put where the emulator's
// are, because drawn ones are smoother than real ones.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "emulator/emulator.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::bench {

enum class Robots { drawn, photographed };

class ArenaFilm {
 public:
  // `emulator` is an emulator's file, or its text. Robots walk from the first frame.
  ArenaFilm(const hal::Config& emulator, Robots robots);

  // The next frame: time passes, every camera takes a picture.
  void next();
  const std::vector<cv::Mat>& pictures() const { return pictures_; }
  hal::LabTime now() const { return emulator_.now(); }
  const emulator::Emulator& emulator() const { return emulator_; }
  // In the middle of that camera's view, pixels.
  double robot_radius_px(std::size_t camera) const;

 private:
  struct CutOut {
    cv::Mat bgr;
    double x_px, y_px, r_px, led_rad;  // within it; the direction of the LED as the picture shows it, y down
  };
  void photograph(std::size_t camera, cv::Mat& out) const;
  void paste(const CutOut& cut_out, const sim_ode::SimulatedArena::Seen& robot, const emulator::CameraModel& model,
             cv::Mat& out) const;

  emulator::Emulator emulator_;
  hal::LabTime begun_{0};
  std::int64_t frame_ = 0;
  std::vector<cv::Mat> pictures_, empty_;  // of each camera
  std::vector<CutOut> cut_outs_;
};

}  // namespace arkmesh::bench
