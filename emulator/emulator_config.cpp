// What the keys are, and what cannot be.
#include "emulator/emulator_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "hal/arenas/arena_config.hpp"
#include "tracker/detect/marker_finder.hpp"

namespace arkmesh::emulator {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr std::size_t max_cameras = 16;

// Tells now, not when the first picture is drawn, whether a camera can look like that.
void check_lens(const hal::Section& section, CameraSettings camera, double width_m, double height_m) {
  try {
    if (camera.focal_px == 0) {
      const double w = width_m / 2, h = height_m / 2;
      camera.focal_px = CameraModel::focal_to_fit(camera.width_px, camera.height_px, camera.pose,
                                                  {{-w, -h}, {w, -h}, {-w, h}, {w, h}}, 0.02);
    }
    const CameraModel model(camera.width_px, camera.height_px, camera.focal_px,
                            camera.width_px / 2.0 + camera.centre_x_px, camera.height_px / 2.0 + camera.centre_y_px,
                            camera.distortion, camera.pose);
  } catch (const std::invalid_argument& error) {
    section.refuse("name", std::string("this camera ") + error.what());
  }
}

}  // namespace

void CameraSettings::fields(const hal::Section& camera) {
  camera.field("name", name, {.help = "name of the camera, part of its URL", .default_is = "camera and its number"});
  camera.field("width_px", width_px, {{64, 8192}, "px", "width of the images"});
  camera.field("height_px", height_px, {{64, 8192}, "px", "height of the images"});
  camera.field("x_m", pose.x_m, {{-100, 100}, "m", "position of the camera"});
  camera.field("y_m", pose.y_m, {{-100, 100}, "m", "position of the camera"});
  camera.field("z_m", pose.z_m, {{0.1, 100}, "m", "height of the camera above the arena"});
  camera.field(
      "look_x_m", look_x_m,
      {.range = {-100, 100}, .unit = "m", .help = "point of the arena on the optical axis", .default_is = "x_m"});
  camera.field(
      "look_y_m", look_y_m,
      {.range = {-100, 100}, .unit = "m", .help = "point of the arena on the optical axis", .default_is = "y_m"});
  camera.field("roll_deg", roll_deg, {{-360, 360}, "deg", "rotation about the optical axis"});
  camera.field("focal_px", focal_px, {{0, 100'000}, "px", "focal length; 0: the longest that shows the whole arena"});
  camera.field("centre_x_px", centre_x_px, {{-500, 500}, "px", "offset of the principal point from the image centre"});
  camera.field("centre_y_px", centre_y_px, {{-500, 500}, "px", "offset of the principal point from the image centre"});
  camera.field("distortion", distortion_terms, {{-10, 10}, "", "distortion coefficients k1, k2, p1, p2, k3"});
  camera.field("brightness", brightness, {{0.05, 4}, "", "brightness of the whole image"});
  camera.field("vignetting", vignetting, {{0, 0.9}, "", "share of light lost in the image corners"});
  camera.field("blur_px", blur_px, {{0, 10}, "px", "s.d. of the blur"});
  camera.field("noise", noise, {{0, 30}, "", "s.d. of the image noise, of 255"});
  camera.field("led_brightness", led_brightness, {{0, 10}, "", "brightness of LEDs; at 1 their centres saturate"});
  camera.field(
      "overlap", overlap,
      {{0, 1}, "", "share of an LED's light that the neighbouring colour filter passes: green LEDs look cyan"});
  camera.field("latency_s", latency, {{0, 2}, "s", "time from exposure to arrival"});
}

void CameraSettings::check(const hal::Section& camera) {
  pose.look_x_m = std::isnan(look_x_m) ? pose.x_m : look_x_m;
  pose.look_y_m = std::isnan(look_y_m) ? pose.y_m : look_y_m;
  pose.roll_rad = degree * roll_deg;
  if (distortion_terms.size() != 5) camera.refuse("distortion", "must hold five numbers: k1, k2, p1, p2, k3");
  std::ranges::copy(distortion_terms, distortion.begin());
}

void Scene::fields(const hal::Section& scene) {
  scene.field("arena_grey", arena_grey, {{30, 250}, "", "grey level of the arena, of 255, where the light is 1"});
  scene.field("texture", texture, {{0, 0.5}, "", "contrast of the mottled arena surface"});
  scene.field("wall_m", wall_m, {{0, 0.2}, "m", "width of the frame around the arena"});
  scene.field("wall_grey", wall_grey, {{0, 250}, "", "grey level of the frame, of 255; robots have about 40"});
  scene.field("light_slope", light_slope, {{0, 0.8}, "", "relative increase in brightness towards the lamp"});
  scene.field("light_from_deg", light_from_deg, {{-360, 360}, "deg", "direction of the lamp, from +x"});
  scene.field("shadow", shadow, {{0, 0.9}, "", "share of light that a robot blocks from the arena below it"});
  scene.field("cell_brightness", cell_brightness,
              {{0, 5}, "", "brightness of coin cells: 1 is steel, 3 is overexposed to white"});
  scene.field("cell_radius", cell_radius, {{0.5, 0.85}, "", "radius of coin cells, as a fraction of a robot's radius"});
  scene.field("glare", glare, {{0, 1}, "", "strength of the lamp's reflection on each robot, on the lamp's side"});
  scene.field("domes", domes, {{0, 1}, "", "strength of the lamp's reflection in unlit LEDs"});
  scene.field("distractors", distractors,
              {.help = "add paper, cables and similar objects around the arena, and stickers in it"});
  scene.field("robot_height_m", stated_height_m,
              {.range = {0, 0.3},
               .unit = "m",
               .help = "height of the Kilobots' boards, or of the other robots' markers",
               .default_is = "the robot's"});
  scene.field("markers", marker_family,
              {.help = "family of the robots' markers", .one_of = tracker::MarkerFinder::families()});
  scene.field("marker_m", marker_m, {{0.005, 1}, "m", "side of a marker's black square"});
}

void EmulatorConfig::Event::fields(const hal::Section& event) {
  event.field("at_s", at, {{0, 1e7}, "s", "emulator time of the event"});
  event.field("do", what, {.help = "a command of the control port", .sample = "\"say run\"", .required = true});
}

void EmulatorConfig::fields(const hal::Section& emulator) {
  emulator.field("seed", seed, {.help = "seed of all random numbers"});
  emulator.field("frames_per_s", frames_per_s, {{0.1, 240}, "1/s", "frame rate of every camera"});
  emulator.field("exposure_s", exposure, {{0, 1}, "s", "exposure time"});
  emulator.field("ids", ids,
                 {.help = "ids (kilo_uid) of the robots", .one_of = {"in_order", "shuffled", "unassigned"}});
  emulator.field("listen", listen, {.help = "IP address of the ports"});
  emulator.field("camera_port", camera_port, {.help = "port of the cameras' streams; 0: any free one"});
  emulator.field("ohc_port", ohc_port, {.help = "port of the overhead controller"});
  emulator.field("nodes_port", nodes_port, {.help = "port of the robots' Aseba nodes, as behind one asebaswitch"});
  emulator.field("control_port", control_port, {.help = "port for commands"});
  std::filesystem::path link = ohc_link;
  emulator.field("ohc_link", link, {.help = "symbolic link to create to the controller's pseudo-terminal"});
  ohc_link = link.string();
  emulator.field("jpeg_quality", jpeg_quality, {{10, 100}, "", "JPEG quality of the images"});
  emulator.field("scene", scene);
  emulator.field("camera", cameras);
  emulator.field("event", events);
}

EmulatorConfig read_emulator_config(const hal::Section& root) {
  const hal::Section emulator = root.section("emulator");
  auto out = emulator.read<EmulatorConfig>();
  out.frame_period = hal::LabTime{static_cast<std::int64_t>(std::llround(1 / out.frames_per_s * 1e6))};
  const auto sides = root.section("arena").read<hal::ArenaSides>();
  out.scene.width_m = sides.width_m;
  out.scene.height_m = sides.height_m;
  out.scene.seed = out.seed;
  out.scene.light_from_rad = degree * out.scene.light_from_deg;

  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  for (std::size_t i = 0; i < out.cameras.size(); ++i) {
    const hal::Section section = emulator.section("camera", static_cast<int>(i));
    CameraSettings& camera = out.cameras[i];
    if (camera.name.empty()) camera.name = fmt::format("camera{}", i);
    if (camera.name.size() > 40 || !std::ranges::all_of(camera.name, is_plain))
      section.refuse("name", "must be 1 to 40 letters, digits, '_' or '-': it becomes part of a URL");
    for (std::size_t k = 0; k < i; ++k)
      if (out.cameras[k].name == camera.name) section.refuse("name", "is used by another camera as well");
    if (i == max_cameras) section.refuse("name", fmt::format("exceeds the limit of {} cameras", max_cameras));
    check_lens(section, camera, sides.width_m, sides.height_m);
  }
  if (out.cameras.empty()) {
    CameraSettings camera;
    camera.name = "camera0";
    camera.pose.z_m = 1.4 * std::max(out.scene.width_m, out.scene.height_m);
    out.cameras.push_back(camera);
  }
  std::ranges::stable_sort(out.events, {}, &EmulatorConfig::Event::at);
  return out;
}

}  // namespace arkmesh::emulator
