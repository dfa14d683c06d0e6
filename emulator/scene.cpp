// Each pixel's sight is followed to the arena, four times for smooth edges; in between a grid of exact sights it is
// interpolated.
#include "emulator/scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "hal/platforms/kilobot/body.hpp"
#include "hal/random.hpp"

namespace arkmesh::emulator {
namespace {

using Colour = cv::Vec3f;

// Smooth noise of unit wavelength, about -1..1; depends on place and key only.
double mottle(double x, double y, std::uint64_t key) {
  const double fx = std::floor(x), fy = std::floor(y), a = x - fx, b = y - fy;
  const auto corner = [&](double dx, double dy) {
    const auto cx = static_cast<std::uint64_t>(static_cast<std::int64_t>(fx + dx)),
               cy = static_cast<std::uint64_t>(static_cast<std::int64_t>(fy + dy));
    return static_cast<double>(hal::mix64(key ^ hal::mix64(cx * 0x9e3779b97f4a7c15ULL ^ cy)) >> 11) * 0x1.0p-52 - 1;
  };
  const double sa = a * a * (3 - 2 * a), sb = b * b * (3 - 2 * b);
  return (1 - sb) * ((1 - sa) * corner(0, 0) + sa * corner(1, 0)) + sb * ((1 - sa) * corner(0, 1) + sa * corner(1, 1));
}

struct Thing {
  enum class Shape { box, disc, cable } shape;
  double x_m, y_m, turn_rad, half_length_m, half_width_m;
  Colour colour;
};

// The surface under a point, lit by light 1.
class Surface {
 public:
  explicit Surface(const Scene& scene) : scene_(scene) {
    hal::RandomStream chance(scene.seed, "room/scene");
    key_ = chance.next();
    const double w = scene.width_m / 2, h = scene.height_m / 2;
    // specks of dust are always there
    for (int k = 0; k < 12; ++k)
      things_.push_back({Thing::Shape::disc,
                         chance.uniform(-w, w),
                         chance.uniform(-h, h),
                         0,
                         chance.uniform(0.0005, 0.0015),
                         0,
                         {95, 98, 100}});
    if (!scene.distractors) return;
    const double beside = 0.09, robot_m = hal::kilobot::body_radius_m;
    things_.push_back({Thing::Shape::box, -w - beside, 0.4 * h, 0.1, 0.06, 0.045, {238, 238, 236}});
    things_.push_back({Thing::Shape::disc, w + beside, -0.5 * h, 0, 0.04, 0, {70, 96, 62}});
    things_.push_back({Thing::Shape::disc, w + beside, -0.5 * h, 0, 0.012, 0, {40, 44, 40}});
    things_.push_back({Thing::Shape::cable, 0.2 * w, h + 0.05, 0, 0.5 * w, 0.0022, {30, 30, 32}});
    things_.push_back({Thing::Shape::cable, w + 0.05, 0.3 * h, 1.5, 0.4 * h, 0.0025, {36, 34, 34}});
    things_.push_back({Thing::Shape::box, -0.4 * w, -h - 0.06, 0.5, 0.07, 0.004, {150, 60, 40}});
    things_.push_back({Thing::Shape::disc, -w - 0.05, -0.6 * h, 0, robot_m, 0, {190, 190, 192}});
    for (int k = 0; k < 3; ++k)
      things_.push_back({Thing::Shape::box, chance.uniform(-0.8 * w, 0.8 * w), chance.uniform(-0.8 * h, 0.8 * h),
                         chance.uniform(0, 3), 0.01, 0.004, k == 0 ? Colour{150, 120, 215} : Colour{120, 190, 200}});
  }

  // No edge lies within `reach` of that point.
  bool smooth_at(double x, double y, double reach) const {
    const double out = std::max(std::abs(x) - scene_.width_m / 2, std::abs(y) - scene_.height_m / 2);
    if (std::abs(out) < reach || std::abs(out - scene_.wall_m) < reach) return false;
    return std::ranges::none_of(things_, [&](const Thing& thing) {
      const double dx = x - thing.x_m, dy = y - thing.y_m,
                   near = thing.half_length_m + thing.half_width_m + 0.02 + reach;
      return dx * dx + dy * dy < near * near;
    });
  }

  Colour at(double x, double y) const {
    const double w = scene_.width_m / 2, h = scene_.height_m / 2, out = std::max(std::abs(x) - w, std::abs(y) - h);
    Colour colour;
    if (out <= 0) {
      const double shade =
          1 + scene_.texture * (0.6 * mottle(x * 9, y * 9, key_) + 0.4 * mottle(x * 160, y * 160, key_ + 1));
      colour = Colour(1.0F, 1.005F, 0.99F) * static_cast<float>(scene_.arena_grey * shade);
    } else if (out < scene_.wall_m) {
      colour = Colour(0.95F, 0.99F, 1.06F) *
               static_cast<float>(scene_.wall_grey * (1 + 0.06 * mottle(x * 60, y * 60, key_ + 2)));
    } else {
      // the rest of the arena: wood
      const double grain = mottle(x * 6, y * 90, key_ + 3) + 0.5 * mottle(x * 20, y * 300, key_ + 4);
      colour = Colour(92, 112, 130) * static_cast<float>(1 + 0.08 * grain);
    }
    for (const Thing& thing : things_)
      if (covers(thing, x - thing.x_m, y - thing.y_m)) colour = thing.colour;
    return colour * static_cast<float>(scene_.light_at(x, y));
  }

 private:
  static bool covers(const Thing& thing, double dx, double dy) {
    const double reach = thing.half_length_m + thing.half_width_m;
    if (thing.shape != Thing::Shape::cable && dx * dx + dy * dy > reach * reach) return false;
    if (thing.shape == Thing::Shape::disc) return true;
    const double along = dx * std::cos(thing.turn_rad) + dy * std::sin(thing.turn_rad),
                 across = dy * std::cos(thing.turn_rad) - dx * std::sin(thing.turn_rad);
    if (std::abs(along) > thing.half_length_m) return false;
    return std::abs(thing.shape == Thing::Shape::cable ? across - 0.012 * std::sin(along * 24) : across) <
           thing.half_width_m;
  }

  const Scene& scene_;
  std::uint64_t key_ = 0;
  std::vector<Thing> things_;
};

// Where sights meet a plane, for all pixels: exact on a grid, linear between.
class Sights {
 public:
  template <class Meet>
  Sights(const CameraModel& camera, Meet&& meet) : columns_(camera.width_px() / step + 2) {
    const int rows = camera.height_px() / step + 2;
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns_; ++c) grid_.push_back(meet(camera.ideal({c * step - 0.5, r * step - 0.5})));
  }
  // Pixel centres are whole numbers.
  std::optional<cv::Point2d> at(double x_px, double y_px) const {
    const double u = (x_px + 0.5) / step, v = (y_px + 0.5) / step;
    const int c = static_cast<int>(u), r = static_cast<int>(v);
    const auto* const top = &grid_[static_cast<std::size_t>(r * columns_ + c)];
    const auto* const below = top + columns_;
    if (!top[0] || !top[1] || !below[0] || !below[1]) return std::nullopt;
    const double a = u - c, b = v - r;
    return (1 - b) * ((1 - a) * *top[0] + a * *top[1]) + b * ((1 - a) * *below[0] + a * *below[1]);
  }

 private:
  static constexpr int step = 8;
  int columns_;
  std::vector<std::optional<cv::Point2d>> grid_;
};

// colour_at(place) for four places of each pixel, or for its middle where smooth_at(place) says that no edge is near;
// `nowhere` where a sight meets nothing.
template <class Look, class Smooth>
cv::Mat draw(const CameraModel& camera, const Sights& sights, Colour nowhere, double vignetting, Look&& colour_at,
             Smooth&& smooth_at) {
  cv::Mat out(camera.height_px(), camera.width_px(), CV_8UC3);
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      Colour sum(0, 0, 0);
      if (const auto middle = sights.at(x, y); middle && smooth_at(*middle)) {
        sum = 4 * colour_at(*middle);
      } else {
        for (int k = 0; k < 4; ++k) {
          const auto place = sights.at(x + (k % 2 ? 0.25 : -0.25), y + (k / 2 ? 0.25 : -0.25));
          sum += place ? colour_at(*place) : nowhere;
        }
      }
      sum *= static_cast<float>(vignetting_at(camera, vignetting, x, y) / 4);
      out.at<cv::Vec3b>(y, x) = {cv::saturate_cast<std::uint8_t>(sum[0]), cv::saturate_cast<std::uint8_t>(sum[1]),
                                 cv::saturate_cast<std::uint8_t>(sum[2])};
    }
  return out;
}

}  // namespace

double Scene::light_at(double x_m, double y_m) const {
  const double half = std::hypot(width_m, height_m) / 2,
               towards = (x_m * std::cos(light_from_rad) + y_m * std::sin(light_from_rad)) / half;
  return std::clamp(1 + light_slope * towards, 0.2, 2.0);
}

double vignetting_at(const CameraModel& camera, double vignetting, double x_px, double y_px) {
  const double dx = 2 * x_px / camera.width_px() - 1, dy = 2 * y_px / camera.height_px() - 1,
               r2 = (dx * dx + dy * dy) / 2;
  return 1 - vignetting * r2 * r2;
}

cv::Mat draw_scene(const Scene& scene, const CameraModel& camera, double vignetting) {
  const Surface surface(scene);
  const Sights sights(camera, [&camera](cv::Point2d ideal) { return camera.meets_plane(ideal, 0); });
  const auto middle = camera.project_near(0, 0, 0);
  const double pixel_m = middle ? 1 / std::sqrt(std::abs(middle->xx * middle->yy - middle->xy * middle->yx)) : 0.01;
  return draw(
      camera, sights, {40, 40, 42}, vignetting, [&surface](cv::Point2d at) { return surface.at(at.x, at.y); },
      [&surface, pixel_m](cv::Point2d at) { return surface.smooth_at(at.x, at.y, 3 * pixel_m); });
}

cv::Mat draw_chessboard(const CameraModel& camera, int columns, int rows, double square_m, std::uint64_t number,
                        std::uint64_t seed) {
  // The board's frame: its corner (0, 0, 0) is the first inner corner. Poses are drawn until one is wholly in view.
  hal::RandomStream chance(seed, "room/chessboard", number);
  const double board_w = (columns + 1) * square_m, board_h = (rows + 1) * square_m, focal = camera.matrix()(0, 0);
  cv::Matx33d rotation;
  cv::Vec3d place;
  for (int attempt = 0; attempt < 10'000; ++attempt) {
    const double roll = chance.uniform(-std::numbers::pi, std::numbers::pi), tilt = chance.uniform(0, 0.6),
                 about = chance.uniform(-std::numbers::pi, std::numbers::pi);
    const cv::Matx33d turn(std::cos(roll), -std::sin(roll), 0, std::sin(roll), std::cos(roll), 0, 0, 0, 1);
    const cv::Matx33d to(std::cos(about), -std::sin(about), 0, std::sin(about), std::cos(about), 0, 0, 0, 1);
    const cv::Matx33d lean(1, 0, 0, 0, std::cos(tilt), -std::sin(tilt), 0, std::sin(tilt), std::cos(tilt));
    rotation = to * lean * to.t() * turn;
    // from a third of the picture to nearly all of it
    const double distance =
        focal * std::max(board_w / camera.width_px(), board_h / camera.height_px()) / chance.uniform(0.35, 0.9);
    const cv::Vec3d middle(chance.uniform(-0.6, 0.6) * distance * camera.width_px() / focal / 2 * 1.4,
                           chance.uniform(-0.6, 0.6) * distance * camera.height_px() / focal / 2 * 1.4, distance);
    place = middle - rotation * cv::Vec3d((columns - 1) * square_m / 2, (rows - 1) * square_m / 2, 0);
    bool in_view = true;
    for (const auto& [u, v] : {std::pair{-2, -2}, {columns + 1, -2}, {-2, rows + 1}, {columns + 1, rows + 1}}) {
      const cv::Vec3d at = rotation * cv::Vec3d(u * square_m, v * square_m, 0) + place;
      // asked of the camera by way of its own frame
      const cv::Vec3d arena = camera.rotation().t() * (at - camera.translation());
      const auto pixel = camera.project(arena[0], arena[1], arena[2]);
      in_view = in_view && pixel && pixel->x > 0 && pixel->y > 0 && pixel->x < camera.width_px() - 1 &&
                pixel->y < camera.height_px() - 1;
    }
    if (in_view) break;
  }
  const cv::Vec3d normal = rotation * cv::Vec3d(0, 0, 1);
  const Sights sights(camera, [&](cv::Point2d ideal) -> std::optional<cv::Point2d> {
    const cv::Vec3d sight(ideal.x, ideal.y, 1);
    const double towards = normal.dot(sight);
    if (std::abs(towards) < 1e-9 || normal.dot(place) / towards <= 0) return std::nullopt;
    const cv::Vec3d at = rotation.t() * (sight * (normal.dot(place) / towards) - place);
    return cv::Point2d(at[0] / square_m, at[1] / square_m);
  });
  const std::uint64_t key = hal::mix64(seed + number);
  return draw(
      camera, sights, {120, 122, 124}, 0.15,
      [&](cv::Point2d at) -> Colour {
        const double u = std::floor(at.x), v = std::floor(at.y);
        const auto shade = static_cast<float>(1 + 0.04 * mottle(at.x / 3, at.y / 3, key));
        if (u < -2 || v < -2 || u > columns || v > rows) return Colour(118, 120, 122) * shade;
        if (u < -1 || v < -1 || u > columns - 1 || v > rows - 1) return Colour(215, 215, 213) * shade;  // the margin
        return static_cast<std::int64_t>(u + v) % 2 == 0 ? Colour(38, 38, 40) * shade : Colour(215, 215, 213) * shade;
      },
      [](cv::Point2d) { return false; });
}

}  // namespace arkmesh::emulator
