// One camera over the arena: takes pictures of the robots at their true places. The empty arena is drawn once; robots
// are laid over it at fractions of a pixel. The same robots and number give the same picture.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "emulator/camera_model.hpp"
#include "emulator/robot_look.hpp"
#include "emulator/scene.hpp"
#include "hal/config/config.hpp"
#include "hal/random.hpp"
#include "sim_ode/simulated_arena.hpp"

namespace arkmesh::emulator {

struct CameraSettings {
  std::string name;
  int width_px = 1920, height_px = 1080;
  CameraPose pose;
  double focal_px = 0;                      // 0: as long as the whole arena fits
  double centre_x_px = 0, centre_y_px = 0;  // offset of the lens from the picture's centre
  std::array<double, 5> distortion{};       // k1, k2, p1, p2, k3
  double brightness = 1;                    // of the whole picture, LEDs included
  double vignetting = 0.2;                  // share of light lost in the corners
  double blur_px = 0.7;                     // s.d.
  double noise = 2;                         // s.d., of 255
  double led_brightness = 1;                // 1: the core saturates
  double overlap = 0;                       // share of an LED's light that the neighbouring colour filter passes, too
  hal::LabTime latency{0};                  // from exposure to the picture's arrival

  // Keys of [[emulator.camera]]; pose and distortion are made of those below.
  double roll_deg = 0, look_x_m = std::numeric_limits<double>::quiet_NaN(), look_y_m = look_x_m;
  std::vector<double> distortion_terms{0, 0, 0, 0, 0};
  void fields(const hal::Section& camera);
  void check(const hal::Section& camera);
};

// A hand over the arena: hides what is under it.
struct Hand {
  double x_m = 0, y_m = 0;
};

class Camera {
 public:
  // Throws std::invalid_argument with the end of a sentence when it cannot look like that.
  Camera(const CameraSettings& settings, const Scene& scene);

  const CameraSettings& settings() const { return settings_; }
  // As it is now; calibration files are written from the one it was made with.
  const CameraModel& model() const { return model_; }
  const CameraModel& model_at_first() const { return first_model_; }
  // Somebody has knocked against it: it hangs elsewhere. Draws the arena anew.
  void move_to(const CameraPose& pose);
  const CameraPose& pose() const { return pose_; }

  // BGR, 8 bit. `number` chooses the noise.
  void picture(std::span<const sim_ode::SimulatedArena::Seen> robots, std::span<const Hand> hands, std::uint64_t number,
               cv::Mat& out) const;
  // Without light: noise only.
  void dark_picture(std::uint64_t number, cv::Mat& out) const;
  // This camera's noise, on any picture of its size.
  void add_noise(std::uint64_t number, cv::Mat& out) const;

 private:
  CameraModel make_model(const CameraPose& pose) const;
  void draw_table();
  void add_shadow(const sim_ode::SimulatedArena::Seen& robot, cv::Mat& out) const;
  void add_body(const sim_ode::SimulatedArena::Seen& robot, const RobotLook& look, cv::Mat& out) const;
  void add_marked_body(const sim_ode::SimulatedArena::Seen& robot, cv::Mat& out) const;
  void add_marker(const sim_ode::SimulatedArena::Seen& robot, const cv::Mat& marker, cv::Mat& out) const;
  void add_glare(const sim_ode::SimulatedArena::Seen& robot, std::size_t number, cv::Mat& out) const;
  void add_led(const sim_ode::SimulatedArena::Seen& robot, const RobotLook& look, cv::Mat& out) const;
  void add_hand(const Hand& hand, cv::Mat& out) const;
  const RobotLook& look_of(std::size_t robot) const { return looks_[robot % looks_.size()]; }
  double gain(const sim_ode::SimulatedArena::Seen& robot, const LocalMap& at) const;

  CameraSettings settings_;
  Scene scene_;
  CameraPose pose_;
  CameraModel model_, first_model_;
  double radius_px_ = 0;  // of a robot in the arena's middle
  cv::Mat table_;
  std::vector<RobotLook> looks_;
  std::vector<cv::Mat> markers_;  // by robot, with a white border; empty: Kilobots
  int marker_squares_ = 0;        // a side of one has, without the border
  std::vector<float> light_, ground_light_,
      shade_;  // by squared distance: an LED's light in the air and on the arena, a robot's shadow
  std::vector<std::int8_t> noise_;
  hal::RandomStream chance_;
};

}  // namespace arkmesh::emulator
