#include "tests/bench/arena_film.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "hal/platforms/kilobot/body.hpp"
#include "tests/support/pictures/robot_pictures.hpp"

namespace arkmesh::bench {
namespace {}  // namespace

ArenaFilm::ArenaFilm(const hal::Config& emulator, Robots robots) : emulator_(emulator.root()) {
  // The overhead controller needs two seconds to start.
  emulator_.advance_to(hal::LabTime{3'000'000});
  emulator_.command("say run");
  begun_ = emulator_.now();
  pictures_.resize(emulator_.cameras());
  if (robots == Robots::drawn) return;
  for (std::size_t k = 0; k < emulator_.cameras(); ++k) {
    const auto& camera = emulator_.camera(k);
    empty_.push_back(draw_scene(emulator_.config().scene, camera.model(), camera.settings().vignetting));
    if (camera.settings().blur_px > 0) cv::GaussianBlur(empty_.back(), empty_.back(), {}, camera.settings().blur_px);
  }
  for (const tests::Scene& scene : tests::real_scenes())
    for (const tests::TrueRobot& robot : scene.robots) {
      // A neighbour would be cut out along with it.
      const auto beside = [&](const tests::TrueRobot& other) {
        const double far = std::hypot(other.x_px - robot.x_px, other.y_px - robot.y_px);
        return far > 0 && far < 2.15 * robot.r_px;
      };
      if (std::any_of(scene.robots.begin(), scene.robots.end(), beside)) continue;
      const int half = static_cast<int>(1.4 * robot.r_px) + 3;
      const cv::Rect part =
          cv::Rect(static_cast<int>(robot.x_px) - half, static_cast<int>(robot.y_px) - half, 2 * half, 2 * half) &
          cv::Rect({}, scene.bgr.size());
      const double led_rad =
          robot.led == hal::Led::off ? 0 : std::atan2(robot.led_y_px - robot.y_px, robot.led_x_px - robot.x_px);
      cut_outs_.push_back({scene.bgr(part).clone(), robot.x_px - part.x, robot.y_px - part.y, robot.r_px, led_rad});
    }
}

double ArenaFilm::robot_radius_px(std::size_t camera) const {
  const auto& pose = emulator_.camera(camera).pose();
  const auto at = emulator_.camera(camera).model().project_near(pose.look_x_m, pose.look_y_m,
                                                                emulator_.config().scene.robot_height_m);
  return hal::kilobot::body_radius_m * std::sqrt(std::abs(at->xx * at->yy - at->xy * at->yx));
}

void ArenaFilm::next() {
  emulator_.advance_to(begun_ + ++frame_ * emulator_.config().frame_period);
  for (std::size_t k = 0; k < pictures_.size(); ++k) {
    if (empty_.empty())
      emulator_.picture(k, pictures_[k]);
    else
      photograph(k, pictures_[k]);
  }
}

void ArenaFilm::photograph(std::size_t camera, cv::Mat& out) const {
  empty_[camera].copyTo(out);
  const auto truth = emulator_.truth();
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (truth[i].seen.in_arena)
      paste(cut_outs_[i * 7 % cut_outs_.size()], truth[i].seen, emulator_.camera(camera).model(), out);
  emulator_.camera(camera).add_noise(static_cast<std::uint64_t>(emulator_.now().count()), out);
}

void ArenaFilm::paste(const CutOut& cut_out, const sim_ode::SimulatedArena::Seen& robot,
                      const emulator::CameraModel& model, cv::Mat& out) const {
  const auto at = model.project_near(robot.pose.x_m, robot.pose.y_m, emulator_.config().scene.robot_height_m);
  if (!at) return;
  const double r_px = hal::kilobot::body_radius_m * std::sqrt(std::abs(at->xx * at->yy - at->xy * at->yx));
  const int reach = static_cast<int>(1.3 * r_px) + 1, left = static_cast<int>(at->x_px) - reach,
            top = static_cast<int>(at->y_px) - reach, side = 2 * reach + 1;
  if (left + side <= 0 || top + side <= 0 || left >= out.cols || top >= out.rows) return;
  const double led = robot.pose.heading_rad + hal::kilobot::led_bearing_rad, east = std::cos(led),
               north = std::sin(led);
  const double turn = std::atan2(at->yx * east + at->yy * north, at->xx * east + at->xy * north) - cut_out.led_rad;
  const double scale = r_px / cut_out.r_px, c = scale * std::cos(turn), s = scale * std::sin(turn);
  const cv::Matx23d move(c, -s, at->x_px - left - c * cut_out.x_px + s * cut_out.y_px, s, c,
                         at->y_px - top - s * cut_out.x_px - c * cut_out.y_px);
  // What shrinks is averaged first.
  cv::Mat soft = cut_out.bgr, patch;
  if (scale < 0.8) cv::GaussianBlur(cut_out.bgr, soft, {}, 0.4 / scale);
  cv::warpAffine(soft, patch, move, cv::Size(side, side), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  for (int y = std::max(0, -top); y < std::min(side, out.rows - top); ++y)
    for (int x = std::max(0, -left); x < std::min(side, out.cols - left); ++x) {
      const double off_x = left + x - at->x_px, off_y = top + y - at->y_px;
      const double cover = std::clamp(r_px * 1.01 - std::hypot(off_x, off_y) + 0.5, 0.0, 1.0);
      // a soft shadow beside the robot
      const double shade =
          1 - 0.25 * std::clamp(1.25 - std::hypot(off_x - 0.12 * r_px, off_y - 0.12 * r_px) / r_px, 0.0, 1.0);
      cv::Vec3b& pixel = out.at<cv::Vec3b>(top + y, left + x);
      for (int k = 0; k < 3; ++k)
        pixel[k] =
            cv::saturate_cast<std::uint8_t>(cover * patch.at<cv::Vec3b>(y, x)[k] + (1 - cover) * shade * pixel[k]);
    }
}

}  // namespace arkmesh::bench
