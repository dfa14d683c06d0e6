#include "tests/support/emulated/fitted_cameras.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "hal/platforms/kilobot/body.hpp"
#include "tracker/camera/camera_fit.hpp"

namespace arkmesh::tests {
namespace {

constexpr int columns = 9, rows = 6;
constexpr double square_m = 0.025;
constexpr int grid = 4;  // marks in a row across the view

}  // namespace

FittedCamera fit_by_hand(const emulator::Emulator& emulator, std::size_t number, const ByHand& options) {
  const emulator::Camera& camera = emulator.camera(number);
  const double width_m = emulator.config().scene.width_m, height_m = emulator.config().scene.height_m;
  tracker::LensFit fit({columns, rows, 1000 * square_m});
  for (int n = 0; n < options.boards; ++n) {
    const auto picture_number = static_cast<std::uint64_t>(n);
    cv::Mat picture = draw_chessboard(camera.model_at_first(), columns, rows, square_m, picture_number, options.seed);
    if (camera.settings().blur_px > 0) cv::GaussianBlur(picture, picture, {}, camera.settings().blur_px);
    camera.add_noise(picture_number, picture);
    fit.add(picture);
  }
  const tracker::FittedLens lens = fit.fit();

  // Marks where the middles of a grid of 4 x 4 fields of the view meet the arena.
  const tracker::Calibration truth = true_calibration(camera.model_at_first(), width_m, height_m);
  const double wide_px = camera.model().width_px(), high_px = camera.model().height_px();
  hal::RandomStream chance(options.seed, "tests/clicks/" + camera.settings().name);
  std::vector<tracker::Mark> marks;
  for (int k = 0; k < grid * grid; ++k) {
    const tracker::Point pixel{(k % grid + 0.5) / grid * wide_px, (k / grid + 0.5) / grid * high_px};
    const auto place = truth.to_arena(pixel, 0);
    if (!place || std::abs(place->x) > width_m / 2 || std::abs(place->y) > height_m / 2) continue;
    marks.push_back(
        {{pixel.x + options.click_px * chance.normal(), pixel.y + options.click_px * chance.normal()}, *place});
  }
  const tracker::CameraData data = tracker::place_camera(lens.lens, marks, width_m, height_m);
  FittedCamera fitted{tracker::Calibration(data), lens.error_px, data.error_px, data.error_mm};

  constexpr int steps = 24;
  for (int k = 0; k <= steps * steps + 2 * steps; ++k) {
    const double across = static_cast<double>(k % (steps + 1)) / steps,
                 down = static_cast<double>(k / (steps + 1)) / steps;
    const tracker::Point pixel{across * (wide_px - 1), down * (high_px - 1)};
    const auto is = truth.to_arena(pixel, hal::kilobot::board_height_m),
               seems = fitted.calibration.to_arena(pixel, hal::kilobot::board_height_m);
    if (!is || std::abs(is->x) > width_m / 2 || std::abs(is->y) > height_m / 2) continue;
    const double off_mm = seems ? 1000 * std::hypot(is->x - seems->x, is->y - seems->y) : 1e9;
    fitted.worst_mm = std::max(fitted.worst_mm, off_mm);
    if (std::min({across, down, 1 - across, 1 - down}) >= 0.1)
      fitted.worst_within_mm = std::max(fitted.worst_within_mm, off_mm);
  }
  return fitted;
}

tracker::Calibration true_calibration(const emulator::CameraModel& model, double arena_width_m, double arena_height_m) {
  tracker::CameraData data;
  data.lens.width_px = model.width_px();
  data.lens.height_px = model.height_px();
  for (int i = 0; i < 9; ++i) data.lens.matrix[i] = model.matrix().val[i], data.rotation[i] = model.rotation().val[i];
  data.lens.distortion.assign(model.distortion().begin(), model.distortion().end());
  for (int i = 0; i < 3; ++i) data.translation_m[i] = model.translation()[i];
  data.arena_width_m = arena_width_m;
  data.arena_height_m = arena_height_m;
  return tracker::Calibration(std::move(data));
}

}  // namespace arkmesh::tests
