// One line per key, ranges included.
#include "emulator/emulator_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "hal/arena_config.hpp"

namespace arkmesh::emulator {
namespace {

constexpr double degree = std::numbers::pi / 180;

hal::LabTime microseconds(double s) {
  return hal::LabTime{static_cast<std::int64_t>(std::llround(s * 1e6))};
}

CameraSettings read_camera(const hal::Section& camera, std::size_t number) {
  CameraSettings out;
  out.name = camera.text("name", fmt::format("camera{}", number));
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  if (out.name.empty() || out.name.size() > 40 || !std::ranges::all_of(out.name, plain))
    camera.refuse("name", "must be 1 to 40 letters, digits, '_' or '-': it becomes part of a URL");
  out.width_px = static_cast<int>(camera.integer("width_px", out.width_px, 64, 8192));
  out.height_px = static_cast<int>(camera.integer("height_px", out.height_px, 64, 8192));
  out.pose.x_m = camera.number("x_m", 0, {-100, 100});
  out.pose.y_m = camera.number("y_m", 0, {-100, 100});
  out.pose.z_m = camera.number("z_m", out.pose.z_m, {0.1, 100});
  out.pose.look_x_m = camera.number("look_x_m", out.pose.x_m, {-100, 100});
  out.pose.look_y_m = camera.number("look_y_m", out.pose.y_m, {-100, 100});
  out.pose.roll_rad = degree * camera.number("roll_deg", 0, {-360, 360});
  out.focal_px = camera.number("focal_px", 0, {0, 100'000});
  out.centre_x_px = camera.number("centre_x_px", 0, {-500, 500});
  out.centre_y_px = camera.number("centre_y_px", 0, {-500, 500});
  const std::vector<double> distortion = camera.numbers("distortion", {0, 0, 0, 0, 0}, {-10, 10});
  if (distortion.size() != 5) camera.refuse("distortion", "must hold five numbers: k1, k2, p1, p2, k3");
  std::ranges::copy(distortion, out.distortion.begin());
  out.brightness = camera.number("brightness", out.brightness, {0.05, 4});
  out.vignetting = camera.number("vignetting", out.vignetting, {0, 0.9});
  out.blur_px = camera.number("blur_px", out.blur_px, {0, 10});
  out.noise = camera.number("noise", out.noise, {0, 30});
  out.led_brightness = camera.number("led_brightness", out.led_brightness, {0, 10});
  return out;
}

Scene read_scene(const hal::Section& scene, const hal::Section& arena, std::uint64_t seed) {
  Scene out;
  out.width_m = hal::read_side(arena, "width_m");
  out.height_m = hal::read_side(arena, "height_m");
  out.seed = seed;
  out.arena_grey = scene.number("arena_grey", out.arena_grey, {30, 250});
  out.texture = scene.number("texture", out.texture, {0, 0.5});
  out.wall_m = scene.number("wall_m", out.wall_m, {0, 0.2});
  out.wall_grey = scene.number("wall_grey", out.wall_grey, {0, 250});
  out.light_slope = scene.number("light_slope", out.light_slope, {0, 0.8});
  out.light_from_rad = degree * scene.number("light_from_deg", 126, {-360, 360});
  out.shadow = scene.number("shadow", out.shadow, {0, 0.9});
  out.distractors = scene.flag("distractors", out.distractors);
  out.robot_height_m = scene.number("robot_height_m", out.robot_height_m, {0, 0.1});
  return out;
}

}  // namespace

EmulatorConfig read_emulator_config(const hal::Section& root) {
  const hal::Section emulator = root.section("emulator");
  EmulatorConfig out;
  out.seed = static_cast<std::uint64_t>(emulator.integer("seed", 1, 0));
  out.frame_period = microseconds(1 / emulator.number("frames_per_s", 15, {0.1, 240}));
  out.exposure = microseconds(emulator.number("exposure_s", 0.01, {0, 1}));
  const std::string ids = emulator.choice("ids", "shuffled", {"in_order", "shuffled", "unassigned"});
  out.ids = ids == "in_order"   ? EmulatorConfig::Ids::in_order
            : ids == "shuffled" ? EmulatorConfig::Ids::shuffled
                                : EmulatorConfig::Ids::unassigned;
  out.listen = emulator.text("listen", out.listen);
  out.camera_port = static_cast<std::uint16_t>(emulator.integer("camera_port", out.camera_port, 0, 65'535));
  out.ohc_port = static_cast<std::uint16_t>(emulator.integer("ohc_port", out.ohc_port, 0, 65'535));
  out.control_port = static_cast<std::uint16_t>(emulator.integer("control_port", out.control_port, 0, 65'535));
  out.ohc_link = emulator.path("ohc_link", "").string();
  out.jpeg_quality = static_cast<int>(emulator.integer("jpeg_quality", out.jpeg_quality, 10, 100));
  out.scene = read_scene(emulator.section("scene"), root.section("arena"), out.seed);

  constexpr std::size_t max_cameras = 16;
  for (const hal::Section& camera : emulator.sections("camera")) {
    out.cameras.push_back(read_camera(camera, out.cameras.size()));
    for (std::size_t k = 0; k + 1 < out.cameras.size(); ++k)
      if (out.cameras[k].name == out.cameras.back().name) camera.refuse("name", "is that of another camera too");
    if (out.cameras.size() > max_cameras)
      camera.refuse("name", fmt::format("is one camera more than the {} of an emulator", max_cameras));
    // tells now, not when the first picture is drawn
    try {
      CameraSettings small = out.cameras.back();
      if (small.focal_px == 0) {
        const double w = out.scene.width_m / 2, h = out.scene.height_m / 2;
        small.focal_px = CameraModel::focal_to_fit(small.width_px, small.height_px, small.pose,
                                                   {{-w, -h}, {w, -h}, {-w, h}, {w, h}}, 0.02);
      }
      const CameraModel model(small.width_px, small.height_px, small.focal_px, small.width_px / 2.0 + small.centre_x_px,
                              small.height_px / 2.0 + small.centre_y_px, small.distortion, small.pose);
    } catch (const std::invalid_argument& error) {
      camera.refuse("name", std::string("this camera ") + error.what());
    }
  }
  if (out.cameras.empty()) {
    CameraSettings camera;
    camera.name = "camera0";
    camera.pose.z_m = 1.4 * std::max(out.scene.width_m, out.scene.height_m);
    out.cameras.push_back(camera);
  }

  for (const hal::Section& event : emulator.sections("event"))
    out.events.push_back({microseconds(event.number("at_s", 0, {0, 1e7})), event.required_text("do")});
  std::ranges::stable_sort(out.events, {}, &EmulatorConfig::Event::at);
  return out;
}

}  // namespace arkmesh::emulator
