#include "testbed/kilobot_settings.hpp"

#include <fmt/format.h>

#include <numbers>
#include <stdexcept>
#include <utility>

#include "hal/arena_config.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "tracker/calibration_file.hpp"
#include "tracker/source.hpp"

namespace arkmesh::testbed {
namespace {

// The key of each camera's table that is wrong is refused there.
tracker::Calibration calibration_of(const hal::Section& section, const CameraSettings& camera, std::size_t number,
                                    std::size_t all, const hal::ArenaConfig& arena) {
  if (tracker::source_kind(camera.source) == tracker::SourceKind::recording)
    section.refuse(
        "source",
        "is no camera: give a camera's number, /dev/video..., or a URL such as http://127.0.0.1:8090/camera0");
  if (camera.calibration.empty())
    section.refuse("calibration", "is missing: give the file that arkmesh calibrate made");
  try {
    tracker::CameraData data = read_calibration_of(camera, number, all);
    data.arena_width_m = arena.width_m;
    data.arena_height_m = arena.height_m;
    return tracker::Calibration(std::move(data));
  } catch (const std::runtime_error& wrong) {
    section.refuse("calibration", wrong.what());
  }
}

}  // namespace

std::vector<CameraSettings> read_cameras(const hal::Section& kilobot) {
  std::vector<CameraSettings> out;
  for (const hal::Section& camera : kilobot.sections("cameras"))
    out.push_back({camera.required_text("source"), camera.path("calibration", ""), camera.text("camera", "")});
  return out;
}

tracker::CameraData read_calibration_of(const CameraSettings& camera, std::size_t number, std::size_t all) {
  const std::vector<tracker::NamedCamera> cameras = tracker::read_calibrations(camera.calibration);
  // A file of the whole arena holds its cameras in the order of the configuration, unless they are named.
  if (camera.name.empty() && cameras.size() > 1 && cameras.size() == all) return cameras[number].data;
  return tracker::read_calibration(camera.calibration, camera.name);
}

KilobotSettings read_kilobot_settings(const hal::Section& arena, const std::string& lab,
                                      std::optional<std::size_t> emulated_cameras) {
  const hal::ArenaConfig config = hal::read_arena_config(arena, hal::kilobot::body_radius_m);
  const hal::Section kilobot = arena.section("kilobot");
  KilobotSettings out;
  out.window.keep_video = kilobot.flag("video", false);
  out.window.open = kilobot.flag("window", true);
  out.window.port = static_cast<std::uint16_t>(kilobot.integer("window_port", 0, 0, 65535));
  const std::vector<hal::Section> sections = kilobot.sections("cameras");
  if (emulated_cameras) {
    if (sections.size() != *emulated_cameras)
      kilobot.refuse("cameras", fmt::format("must be as many as the emulator's, which has {}", *emulated_cameras));
    kilobot.leave_alone("port");
  }
  out.tracking.following.led_offset_rad = kilobot.number("led_offset_deg", 44, {-180, 180}) * std::numbers::pi / 180;
  out.tracking.body.board_m = kilobot.number("board_height_m", tracker::board_height_m, {0, 0.2});
  out.tracking.body.led_m = out.tracking.body.board_m + 0.002;
  out.known_to_ark = kilobot.choice("identity", "spelled", {"spelled", "ark"}) == "ark";
  if (sections.empty())
    kilobot.refuse("cameras",
                   "give one to four cameras, each as [[arena.kilobot.cameras]] with source and calibration");
  if (sections.size() > 4)
    kilobot.refuse("cameras", fmt::format("there are {} cameras; at most four can be used", sections.size()));
  out.cameras = read_cameras(kilobot);
  for (std::size_t i = 0; i < sections.size(); ++i)
    out.calibrations.push_back(calibration_of(sections[i], out.cameras[i], i, sections.size(), config));
  out.arena = hal::kilobot::read_arena_settings(arena, lab, !emulated_cameras);
  out.tracking.expected_robots = out.arena.info.robots.size();
  return out;
}

}  // namespace arkmesh::testbed
