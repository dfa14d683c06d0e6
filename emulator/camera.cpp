#include "emulator/camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "hal/platforms/kilobot/body.hpp"
#include "tracker/detect/marker_finder.hpp"

namespace arkmesh::emulator {
namespace {

constexpr double kilobot_m = hal::kilobot::body_radius_m;
constexpr double cell_above_board_m = 0.007;
// Tables over squared distances, in radii: what lies beyond is nothing.
constexpr double light_reach = 1.5, ground_reach = 2.2, shade_reach = 1.9;
constexpr int table_steps = 1024;
constexpr std::size_t noise_period = 1 << 20;

template <class Value>
std::vector<float> by_square(double reach, Value&& value) {
  std::vector<float> out;
  for (int k = 0; k < table_steps; ++k)
    out.push_back(static_cast<float>(value(std::sqrt((k + 0.5) / table_steps) * reach)));
  // ends at nothing, without a step
  const float last = out.back();
  for (float& entry : out) entry = std::max(0.0F, entry - last);
  return out;
}

double bell(double r, double sd) {
  return std::exp(-r * r / (2 * sd * sd));
}

// A plane's patch around a point, back from pixels: metres per pixel.
struct Patch {
  int left, right, top, bottom;  // pixels, right and bottom excluded
  float x_px, y_px, xx, xy, yx, yy;

  Patch(const LocalMap& at, double reach_m, const cv::Mat& picture)
      : left(clip(at.x_px - reach_m * std::hypot(at.xx, at.xy), picture.cols)),
        right(clip(at.x_px + reach_m * std::hypot(at.xx, at.xy) + 2, picture.cols)),
        top(clip(at.y_px - reach_m * std::hypot(at.yx, at.yy), picture.rows)),
        bottom(clip(at.y_px + reach_m * std::hypot(at.yx, at.yy) + 2, picture.rows)) {
    const double det = at.xx * at.yy - at.xy * at.yx;
    x_px = static_cast<float>(at.x_px);
    y_px = static_cast<float>(at.y_px);
    xx = static_cast<float>(at.yy / det);
    xy = static_cast<float>(-at.xy / det);
    yx = static_cast<float>(-at.yx / det);
    yy = static_cast<float>(at.xx / det);
  }
  static int clip(double at, int size) { return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(size))); }
};

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
}

}  // namespace

Camera::Camera(const CameraSettings& settings, const Scene& scene)
    : settings_(settings), scene_(scene), pose_(settings.pose), chance_(scene.seed, "room/camera/" + settings.name) {
  if (settings_.focal_px == 0) {
    const double w = scene.width_m / 2 + scene.wall_m, h = scene.height_m / 2 + scene.wall_m;
    settings_.focal_px = CameraModel::focal_to_fit(settings.width_px, settings.height_px, settings.pose,
                                                   {{-w, -h}, {w, -h}, {-w, h}, {w, h}}, 0.02);
  }
  model_ = first_model_ = make_model(pose_);
  const auto middle = model_.project_near(settings.pose.look_x_m, settings.pose.look_y_m, scene.robot_height_m);
  if (!middle) throw std::invalid_argument("does not see the arena");
  radius_px_ = scene.body_radius_m * std::sqrt(std::abs(middle->xx * middle->yy - middle->xy * middle->yx));
  if (radius_px_ < 2 || radius_px_ > 200)
    throw std::invalid_argument("shows robots smaller than 4 or larger than 400 pixels; change its height or focal_px");
  constexpr int pixels_a_square = 16;
  for (const hal::RobotId robot : scene.markers)
    markers_.push_back(tracker::marker_picture(scene.marker_family, static_cast<int>(robot), pixels_a_square));
  marker_squares_ = tracker::MarkerFinder::squares(scene.marker_family);
  for (int kind = 0; kind < robot_kinds && markers_.empty(); ++kind)
    looks_.push_back(make_robot_look(kind, radius_px_, settings.blur_px, scene.cell_radius));

  // the core is far too bright for the picture, so that it is white whatever its colour; the halo shows the colour
  const double blur = std::sqrt(settings.blur_px * settings.blur_px + 1.0 / 12) / radius_px_;
  const auto blurred = [blur](double r, double sd) {
    const double wide = std::hypot(sd, blur);
    return sd * sd / (wide * wide) * bell(r, wide);
  };
  const double led = settings.led_brightness;
  light_ = by_square(light_reach, [&](double r) {
    return led * (2200 * blurred(r, 0.08) + 95 * blurred(r, 0.2) + 26 * blurred(r, 0.5));
  });
  ground_light_ = by_square(ground_reach, [&](double r) { return led * (22 * blurred(r, 0.55) + 9 * blurred(r, 1)); });
  shade_ = by_square(shade_reach, [](double r) { return 1 / (1 + std::exp((r - 1.05) / 0.17)); });

  hal::RandomStream noise = chance_;
  for (std::size_t k = 0; k < noise_period; ++k)
    noise_.push_back(static_cast<std::int8_t>(std::clamp(std::lround(noise.normal() * settings.noise), -127L, 127L)));
  draw_table();
}

CameraModel Camera::make_model(const CameraPose& pose) const {
  return {settings_.width_px,
          settings_.height_px,
          settings_.focal_px,
          (settings_.width_px - 1) / 2.0 + settings_.centre_x_px,
          (settings_.height_px - 1) / 2.0 + settings_.centre_y_px,
          settings_.distortion,
          pose};
}

void Camera::move_to(const CameraPose& pose) {
  model_ = make_model(pose);
  pose_ = pose;
  draw_table();
}

void Camera::draw_table() {
  table_ = draw_scene(scene_, model_, settings_.vignetting);
  if (settings_.blur_px > 0) cv::GaussianBlur(table_, table_, {}, settings_.blur_px);
  if (settings_.brightness != 1) table_.convertTo(table_, -1, settings_.brightness);
}

void Camera::picture(std::span<const sim_ode::SimulatedArena::Seen> robots, std::span<const Hand> hands,
                     std::uint64_t number, cv::Mat& out) const {
  table_.copyTo(out);
  for (const sim_ode::SimulatedArena::Seen& robot : robots)
    if (robot.in_arena) add_shadow(robot, out);
  for (std::size_t i = 0; i < robots.size(); ++i)
    if (robots[i].in_arena) {
      if (markers_.empty())
        add_body(robots[i], look_of(i), out);
      else
        add_marked_body(robots[i], out), add_marker(robots[i], markers_[i], out);
      add_glare(robots[i], i, out);
    }
  for (std::size_t i = 0; i < robots.size() && markers_.empty(); ++i)
    if (robots[i].in_arena && robots[i].red + robots[i].green + robots[i].blue > 0) add_led(robots[i], look_of(i), out);
  for (const Hand& hand : hands) add_hand(hand, out);
  add_noise(number, out);
}

void Camera::dark_picture(std::uint64_t number, cv::Mat& out) const {
  out.create(settings_.height_px, settings_.width_px, CV_8UC3);
  out.setTo(cv::Scalar(3, 3, 4));
  add_noise(number, out);
}

double Camera::gain(const sim_ode::SimulatedArena::Seen& robot, const LocalMap& at) const {
  return settings_.brightness * scene_.light_at(robot.pose.x_m, robot.pose.y_m) *
         vignetting_at(model_, settings_.vignetting, at.x_px, at.y_px);
}

// Right under the robot, and falling away from the lamp.
void Camera::add_shadow(const sim_ode::SimulatedArena::Seen& robot, cv::Mat& out) const {
  const double radius_m = scene_.body_radius_m, reach_m = (shade_reach + 0.4) * radius_m;
  const auto at = model_.project_near(robot.pose.x_m, robot.pose.y_m, 0);
  if (!at) return;
  const Patch patch(*at, reach_m, out);
  const auto steps = static_cast<float>(table_steps / (shade_reach * shade_reach * radius_m * radius_m));
  const auto off_x = static_cast<float>(-0.4 * radius_m * std::cos(scene_.light_from_rad)),
             off_y = static_cast<float>(-0.4 * radius_m * std::sin(scene_.light_from_rad));
  const auto depth = static_cast<float>(scene_.shadow);
  for (int y = patch.top; y < patch.bottom; ++y) {
    std::uint8_t* const row = out.ptr<std::uint8_t>(y);
    const float v = static_cast<float>(y) - patch.y_px;
    for (int x = patch.left; x < patch.right; ++x) {
      const float u = static_cast<float>(x) - patch.x_px;
      const float mx = patch.xx * u + patch.xy * v, my = patch.yx * u + patch.yy * v;
      const int near = static_cast<int>((mx * mx + my * my) * steps);
      const int far = static_cast<int>(((mx - off_x) * (mx - off_x) + (my - off_y) * (my - off_y)) * steps);
      float shade = 0;
      if (near < table_steps) shade += 0.5F * shade_[static_cast<std::size_t>(near)];
      if (far < table_steps) shade += 0.5F * shade_[static_cast<std::size_t>(far)];
      if (shade <= 0) continue;
      const float left = 1 - depth * shade;
      for (int c = 0; c < 3; ++c) row[3 * x + c] = to_byte(static_cast<float>(row[3 * x + c]) * left);
    }
  }
}

void Camera::add_body(const sim_ode::SimulatedArena::Seen& robot, const RobotLook& look, cv::Mat& out) const {
  const double c = std::cos(robot.pose.heading_rad), s = std::sin(robot.pose.heading_rad),
               board_m = scene_.robot_height_m;
  const auto middle = model_.project_near(robot.pose.x_m, robot.pose.y_m, board_m);
  if (!middle) return;
  const auto light = static_cast<float>(gain(robot, *middle));

  // three thin legs, from the board's edge down to the arena
  if (radius_px_ > 8)
    for (double angle : {0.0, 2.19, -2.19}) {
      const double x = robot.pose.x_m + 0.017 * std::cos(robot.pose.heading_rad + angle),
                   y = robot.pose.y_m + 0.017 * std::sin(robot.pose.heading_rad + angle);
      const auto upper = model_.project(x, y, board_m), foot = model_.project(x, y, 0);
      if (!upper || !foot || std::abs(foot->x) > 1e4 || std::abs(foot->y) > 1e4) continue;
      const auto fixed = [](const cv::Point2d& p) {
        return cv::Point(static_cast<int>(std::lround(p.x * 16)), static_cast<int>(std::lround(p.y * 16)));
      };
      cv::line(out, fixed(*upper), fixed(*foot), cv::Scalar(118, 122, 126) * light, 1, cv::LINE_AA, 4);
    }

  for (const auto& [texture, height_m] :
       {std::pair{&look.board, board_m}, {&look.cell, board_m + cell_above_board_m}}) {
    const auto at = model_.project_near(robot.pose.x_m, robot.pose.y_m, height_m);
    if (!at) continue;
    const float lit = texture == &look.board ? light : light * static_cast<float>(scene_.cell_brightness);
    const Patch patch(*at, texture->half() * kilobot_m * (texture == &look.board ? 1 : 0.85), out);
    // pixels to robot frame, in radii
    constexpr auto per_radius = static_cast<float>(1 / kilobot_m);
    const auto fc = static_cast<float>(c) * per_radius, fs = static_cast<float>(s) * per_radius;
    const float ahead_u = fc * patch.xx + fs * patch.yx, ahead_v = fc * patch.xy + fs * patch.yy;
    const float left_u = fc * patch.yx - fs * patch.xx, left_v = fc * patch.yy - fs * patch.xy;
    for (int y = patch.top; y < patch.bottom; ++y) {
      std::uint8_t* const row = out.ptr<std::uint8_t>(y);
      const float v = static_cast<float>(y) - patch.y_px;
      for (int x = patch.left; x < patch.right; ++x) {
        const float u = static_cast<float>(x) - patch.x_px;
        const Texture::Texel texel = texture->sample(ahead_u * u + ahead_v * v, left_u * u + left_v * v);
        if (texel.cover < 0.002F) continue;
        std::uint8_t* const pixel = row + 3 * x;
        const float under = 1 - texel.cover;
        pixel[0] = to_byte(static_cast<float>(pixel[0]) * under + texel.blue * lit);
        pixel[1] = to_byte(static_cast<float>(pixel[1]) * under + texel.green * lit);
        pixel[2] = to_byte(static_cast<float>(pixel[2]) * under + texel.red * lit);
      }
    }
  }
}

// An arc on cell or holder where the lamp is mirrored, at the same side of most robots; and a dot in an unlit LED.
void Camera::add_glare(const sim_ode::SimulatedArena::Seen& robot, std::size_t number, cv::Mat& out) const {
  const bool dark = robot.red + robot.green + robot.blue <= 0;
  if (scene_.glare <= 0 && (scene_.domes <= 0 || !dark)) return;
  const double radius_m = scene_.body_radius_m,
               top_m = scene_.robot_height_m + (markers_.empty() ? cell_above_board_m : 0);
  const auto at = model_.project_near(robot.pose.x_m, robot.pose.y_m, top_m);
  if (!at) return;
  hal::RandomStream chance(scene_.seed, "room/glare", number);
  const double arc_r = std::clamp(0.67 + 0.1 * chance.normal(), 0.45, 0.92),
               arc_rad = scene_.light_from_rad + 0.25 * chance.normal(), strength = chance.uniform(0.5, 1.3),
               led_rad = robot.pose.heading_rad + robot.led_bearing_rad,
               led_r = markers_.empty() ? look_of(number).led_radius : 0.9;
  const double led_x = led_r * std::cos(led_rad), led_y = led_r * std::sin(led_rad),
               dome = dark ? 230 * scene_.domes * strength : 0;
  const Patch patch(*at, 1.1 * radius_m, out);
  for (int y = patch.top; y < patch.bottom; ++y)
    for (int x = patch.left; x < patch.right; ++x) {
      const double u = x - patch.x_px, v = y - patch.y_px, mx = (patch.xx * u + patch.xy * v) / radius_m,
                   my = (patch.yx * u + patch.yy * v) / radius_m;
      const double light = 260 * scene_.glare * strength * bell(std::hypot(mx, my) - arc_r, 0.06) *
                               bell(std::remainder(std::atan2(my, mx) - arc_rad, 2 * std::numbers::pi), 0.3) +
                           dome * bell(std::hypot(mx - led_x, my - led_y), std::max(0.05, 0.7 / radius_px_));
      if (light < 1) continue;
      std::uint8_t* const pixel = out.ptr<std::uint8_t>(y) + 3 * x;
      for (int c = 0; c < 3; ++c) pixel[c] = to_byte(static_cast<float>(pixel[c] + settings_.brightness * light));
    }
}

void Camera::add_led(const sim_ode::SimulatedArena::Seen& robot, const RobotLook& look, cv::Mat& out) const {
  const double angle = robot.pose.heading_rad + robot.led_bearing_rad, far_m = look.led_radius * kilobot_m;
  const double led_x = robot.pose.x_m + far_m * std::cos(angle), led_y = robot.pose.y_m + far_m * std::sin(angle);
  const float strongest = std::max({robot.blue, robot.green, robot.red});
  const auto light = static_cast<float>(settings_.brightness);

  // first on the arena around, then in the lens and on the board
  for (const bool ground : {true, false}) {
    const auto at =
        model_.project_near(led_x, led_y, ground ? 0 : scene_.robot_height_m + hal::kilobot::led_above_board_m);
    if (!at) continue;
    const double reach = ground ? ground_reach : light_reach;
    const std::vector<float>& table = ground ? ground_light_ : light_;
    const Patch patch(*at, reach * kilobot_m, out);
    const auto steps = static_cast<float>(table_steps / (reach * reach * kilobot_m * kilobot_m));
    // a camera's colour filters leak: the brighter, the whiter, or, where they overlap, the more another colour
    const auto overlap = static_cast<float>(settings_.overlap);
    const float leak = 0.14F * (1 - overlap);
    const auto seen = [&](float own, float neighbour) {
      const float colour = std::max(own, overlap * neighbour);
      return light * (colour + leak * (strongest - colour));
    };
    const float blue = seen(robot.blue, robot.green), green = seen(robot.green, std::max(robot.blue, 0.3F * robot.red)),
                red = seen(robot.red, 0.3F * robot.green);
    for (int y = patch.top; y < patch.bottom; ++y) {
      std::uint8_t* const row = out.ptr<std::uint8_t>(y);
      const float v = static_cast<float>(y) - patch.y_px;
      for (int x = patch.left; x < patch.right; ++x) {
        const float u = static_cast<float>(x) - patch.x_px;
        const float mx = patch.xx * u + patch.xy * v, my = patch.yx * u + patch.yy * v;
        const int k = static_cast<int>((mx * mx + my * my) * steps);
        if (k >= table_steps) continue;
        const float glow = table[static_cast<std::size_t>(k)];
        std::uint8_t* const pixel = row + 3 * x;
        pixel[0] = to_byte(static_cast<float>(pixel[0]) + glow * blue);
        pixel[1] = to_byte(static_cast<float>(pixel[1]) + glow * green);
        pixel[2] = to_byte(static_cast<float>(pixel[2]) + glow * red);
      }
    }
  }
}

// A fist over the place and an arm that reaches in over the nearer wall in the south.
void Camera::add_hand(const Hand& hand, cv::Mat& out) const {
  const auto fist = model_.project_near(hand.x_m, hand.y_m, 0.06);
  const auto elbow = model_.project(hand.x_m + 0.05, -scene_.height_m / 2 - 0.15, 0.1);
  if (!fist || std::abs(fist->x_px) > 1e4 || std::abs(fist->y_px) > 1e4) return;
  const double scale = std::sqrt(std::abs(fist->xx * fist->yy - fist->xy * fist->yx));
  const cv::Point at(static_cast<int>(fist->x_px), static_cast<int>(fist->y_px));
  const cv::Scalar skin = cv::Scalar(118, 146, 196) * settings_.brightness,
                   sleeve = cv::Scalar(92, 70, 58) * settings_.brightness;
  if (elbow && std::abs(elbow->x) < 1e4 && std::abs(elbow->y) < 1e4)
    cv::line(out, at, {static_cast<int>(elbow->x), static_cast<int>(elbow->y)}, sleeve,
             std::clamp(static_cast<int>(0.05 * scale), 1, 250), cv::LINE_AA);
  cv::circle(out, at, static_cast<int>(0.042 * scale), skin, cv::FILLED, cv::LINE_AA);
}

void Camera::add_noise(std::uint64_t number, cv::Mat& out) const {
  if (settings_.noise <= 0) return;
  hal::RandomStream where(number, "noise");
  const auto bytes = static_cast<std::size_t>(3 * out.cols);
  for (int y = 0; y < out.rows; ++y) {
    const std::int8_t* const noise = noise_.data() + where.below(noise_period - bytes);
    std::uint8_t* const row = out.ptr<std::uint8_t>(y);
    for (std::size_t k = 0; k < bytes; ++k) row[k] = static_cast<std::uint8_t>(std::clamp(row[k] + noise[k], 0, 255));
  }
}

}  // namespace arkmesh::emulator
