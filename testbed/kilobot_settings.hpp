// What a lab's file says of its testbed of Kilobots, [arena.kilobot], read once for everybody.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hal/arenas/arena_config.hpp"
#include "hal/config/config.hpp"
#include "hal/platforms/kilobot/kilobot_arena.hpp"
#include "testbed/kilobot_tracking.hpp"
#include "tracker/camera/calibration_file.hpp"
#include "tracker/camera/camera_controls.hpp"

namespace arkmesh::testbed {

// One of [[arena.kilobot.cameras]].
struct CameraSettings {
  std::string source;                 // required: a number, /dev/video..., or URL
  std::filesystem::path calibration;  // required: a file of `arkmesh calibrate`
  std::string name;                   // camera: its name in that file, when the file contains several
  double latency_ms = 0;  // from light to the time of a picture: its driver's at this machine, else its arrival
  tracker::CameraControls controls;

  void fields(const hal::Section& camera);
};

struct KilobotSettings {
  bool keep_video = false;  // an annotated one of each camera
  tracker::ArenaTrackerSettings tracking = kilobot_tracking();
  double led_offset_deg = testbed::led_offset_deg;  // driving direction minus LED direction, counter-clockwise
  std::filesystem::path robots_file;  // of `arkmesh fit robots`: where each robot's LED is; empty: where others have it
  bool known_to_ark = false;     // identity: "spelled", or "ark" for programs that know ARK's messages 120 and 119 only
  std::filesystem::path record;  // a new folder for everything at the devices, as it came (raw_record.hpp); or nothing
  std::vector<CameraSettings> cameras;                    // one to four
  std::vector<tracker::Calibration> calibrations;         // of each camera, for an arena of this size
  std::vector<std::vector<tracker::Landmark>> landmarks;  // of each camera, when it was calibrated
  hal::kilobot::ArenaSettings arena;  // ids, the overhead controller, and what the beginning puts up with

  void fields(const hal::Section& kilobot);
};

// Throws ConfigError, also for a calibration that is not there. Of an emulated testbed, which has so many cameras and
// an overhead controller of its own, the file's cameras must be as many and no port is read.
KilobotSettings read_kilobot_settings(const hal::Section& arena, const std::string& lab,
                                      std::optional<std::size_t> emulated_cameras = {});

// Where the LEDs are of robots of which the file tells it. Throws ConfigError.
std::map<hal::RobotId, tracker::LedOffset> read_led_offsets(const std::filesystem::path& robots_file);

// The cameras that are named, whether or not their calibration is there. Throws ConfigError.
std::vector<CameraSettings> read_cameras(const hal::Section& kilobot);

// The calibration of camera `number` of `all`, for an arena of that size; `section` is its table, in which what is
// wrong is refused by its key.
tracker::NamedCamera placed_calibration(const hal::Section& section, const CameraSettings& camera, std::size_t number,
                                        std::size_t all, const hal::ArenaConfig& arena);
// The calibration of camera `number` of `all`. Throws std::runtime_error with one sentence.
tracker::NamedCamera read_calibration_of(const CameraSettings& camera, std::size_t number, std::size_t all);

}  // namespace arkmesh::testbed
