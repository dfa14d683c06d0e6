#include "testbed/kilobot_settings.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "hal/arenas/arena_config.hpp"
#include "hal/config/without_secrets.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "tracker/camera/calibration_file.hpp"
#include "tracker/camera/source.hpp"

namespace arkmesh::testbed {
tracker::NamedCamera placed_calibration(const hal::Section& section, const CameraSettings& camera, std::size_t number,
                                        std::size_t all, const hal::ArenaConfig& arena) {
  if (tracker::source_kind(camera.source) == tracker::SourceKind::recording)
    section.refuse(
        "source",
        "is not a camera: give a camera's number, /dev/video..., or a URL such as http://127.0.0.1:8090/camera0");
  if (tracker::source_kind(camera.source) == tracker::SourceKind::url)
    for (const std::string& key : camera.controls.keys())
      section.refuse(key, "can be set only for a camera at this machine: set it in the camera's own menu");
  if (camera.calibration.empty())
    section.refuse("calibration", "is missing: give the file that arkmesh calibrate wrote");
  try {
    tracker::NamedCamera calibrated = read_calibration_of(camera, number, all);
    calibrated.data.arena_width_m = arena.width_m;
    calibrated.data.arena_height_m = arena.height_m;
    return calibrated;
  } catch (const std::runtime_error& wrong) {
    section.refuse("calibration", wrong.what());
  }
}

namespace {

// Of a robots_file; what else is in it is the simulator's.
struct RobotLed {
  int id = 0;
  double bearing_deg = std::numeric_limits<double>::quiet_NaN(), error_deg = 0;

  void fields(const hal::Section& robot) {
    robot.field("id", id, {.range = {0, 65'535}, .help = "id of the robot", .required = true});
    robot.field("led_bearing_deg", bearing_deg,
                {{-180, 180}, "deg", "bearing of its LED, counter-clockwise from ahead"});
    robot.field("led_bearing_error_deg", error_deg, {{0, 180}, "deg", "standard error of that bearing"});
  }
};
struct RobotLeds {
  std::vector<RobotLed> robots;

  void fields(const hal::Section& file) { file.field("robot", robots); }
};

}  // namespace

std::map<hal::RobotId, tracker::LedOffset> read_led_offsets(const std::filesystem::path& robots_file) {
  constexpr double degree = std::numbers::pi / 180;
  std::map<hal::RobotId, tracker::LedOffset> out;
  for (const RobotLed& robot : hal::Config::from_file(robots_file).root().read<RobotLeds>().robots)
    if (!std::isnan(robot.bearing_deg))
      out[static_cast<hal::RobotId>(robot.id)] = {-robot.bearing_deg * degree, robot.error_deg * degree};
  return out;
}

void CameraSettings::fields(const hal::Section& camera) {
  camera.field("source", source,
               {.help = "a camera's number, /dev/video..., or a URL",
                .sample = "\"0\"",
                .required = true,
                .written = hal::without_secrets});
  camera.field("calibration", calibration,
               {.help = "calibration file from arkmesh calibrate", .sample = "\"camera.yaml\""});
  camera.field("camera", name, {.help = "name of the camera in that file, if the file contains several"});
  camera.field("latency_ms", latency_ms,
               {{0, 2000}, "ms", "delay from exposure to time stamp (local cameras: the driver's; others: arrival)"});
  const std::string own = "the camera's own";
  camera.field("exposure_ms", controls.exposure_ms,
               {.range = {0.01, 10'000}, .unit = "ms", .help = "exposure time; local cameras only", .default_is = own});
  camera.field("gain", controls.gain,
               {.range = {0, 1e6}, .help = "gain in the driver's units; local cameras only", .default_is = own});
  camera.field(
      "white_balance_k", controls.white_balance_k,
      {.range = {1000, 20'000}, .unit = "K", .help = "colour temperature; local cameras only", .default_is = own});
}

void KilobotSettings::fields(const hal::Section& kilobot) {
  kilobot.field("video", keep_video, {.help = "keep a video of each camera"});
  kilobot.field("led_offset_deg", led_offset_deg,
                {{-180, 180}, "deg", "driving direction minus LED direction, counter-clockwise"});
  kilobot.field("robots_file", robots_file,
                {.help = "file from `arkmesh fit robots` with each robot's LED bearing, instead of led_offset_deg"});
  kilobot.field("board_height_m", tracking.body.board_m, {{0, 0.2}, "m", "height of robots' boards above the arena"});
  enum class Identity { spelled, ark } identity = known_to_ark ? Identity::ark : Identity::spelled;
  kilobot.field("identity", identity,
                {.help = "identification protocol; \"ark\" for programs that know only ARK's messages 120 and 119",
                 .one_of = {"spelled", "ark"}});
  known_to_ark = identity == Identity::ark;
  kilobot.field("record", record,
                {.help = "record serial bytes and pictures in this new folder, for `arkmesh testbed replay`"});
  kilobot.field("cameras", cameras);
}

std::vector<CameraSettings> read_cameras(const hal::Section& kilobot) {
  return kilobot.get("cameras", std::vector<CameraSettings>());
}

tracker::NamedCamera read_calibration_of(const CameraSettings& camera, std::size_t number, std::size_t all) {
  const std::vector<tracker::NamedCamera> cameras = tracker::read_calibrations(camera.calibration);
  // A file of the whole arena holds its cameras in the order of the configuration, unless they are named.
  if (camera.name.empty() && cameras.size() > 1 && cameras.size() == all) return cameras[number];
  return tracker::read_calibration(camera.calibration, camera.name);
}

KilobotSettings read_kilobot_settings(const hal::Section& arena, const std::string& lab,
                                      std::optional<std::size_t> emulated_cameras) {
  const hal::ArenaConfig config = hal::read_arena_config(arena, hal::kilobot::body_radius_m);
  const hal::Section kilobot = arena.section("kilobot");
  auto out = kilobot.read<KilobotSettings>();
  const std::size_t cameras = out.cameras.size();
  if (emulated_cameras && cameras != *emulated_cameras)
    kilobot.refuse("cameras", fmt::format("must be as many as the emulator's, which has {}", *emulated_cameras));
  out.tracking.following.half_width_m = out.arena.info.width_m / 2;
  out.tracking.following.half_height_m = out.arena.info.height_m / 2;
  out.tracking.following.led_offset_rad = out.led_offset_deg * std::numbers::pi / 180;
  if (!out.robots_file.empty()) {
    if (!std::filesystem::exists(out.robots_file)) kilobot.refuse("robots_file", "there is no such file");
    out.tracking.following.led_offsets = read_led_offsets(out.robots_file);
  }
  out.tracking.body = kilobot_body(out.tracking.body.board_m);
  if (cameras == 0)
    kilobot.refuse("cameras",
                   "give one to four cameras, each as [[arena.kilobot.cameras]] with source and calibration");
  if (cameras > 4) kilobot.refuse("cameras", fmt::format("there are {} cameras; at most four can be used", cameras));
  for (std::size_t i = 0; i < cameras; ++i) {
    tracker::NamedCamera calibrated =
        placed_calibration(kilobot.section("cameras", static_cast<int>(i)), out.cameras[i], i, cameras, config);
    out.calibrations.emplace_back(std::move(calibrated.data));
    out.landmarks.push_back(std::move(calibrated.landmarks));
  }
  out.arena = hal::kilobot::read_arena_settings(arena, lab, !emulated_cameras);
  out.tracking.expected_robots = out.arena.info.robots.size();
  return out;
}

}  // namespace arkmesh::testbed
