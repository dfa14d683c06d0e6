// The keys of an emulator's file: [emulator], [[emulator.camera]], [emulator.scene], [[emulator.event]]; its robots are
// in [arena] and [arena.ode].
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "emulator/camera.hpp"
#include "emulator/scene.hpp"
#include "hal/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::emulator {

struct EmulatorConfig {
  enum class Ids { in_order, shuffled, unassigned };
  // Something that happens by itself; `what` is as on the control port.
  struct Event {
    hal::LabTime at{0};
    std::string what;
  };

  std::uint64_t seed = 1;             // emulator.seed
  hal::LabTime frame_period{66'667};  // 1 / emulator.frames_per_s, 15
  hal::LabTime exposure{10'000};      // emulator.exposure_s
  Ids ids = Ids::shuffled;            // emulator.ids: kilo_uid of the robots; "unassigned" is 65535 for all
  std::string listen = "127.0.0.1";   // emulator.listen
  std::uint16_t camera_port = 8090;   // emulator.camera_port, 0 any free one
  std::uint16_t ohc_port = 8091;      // emulator.ohc_port
  std::uint16_t control_port = 8092;  // emulator.control_port
  std::string ohc_link;   // emulator.ohc_link: a symbolic link to the pseudo-terminal, kept up to date; empty: none
  int jpeg_quality = 90;  // emulator.jpeg_quality
  Scene scene;
  std::vector<CameraSettings> cameras;  // one at least
  std::vector<Event> events;            // ascending times
};

// Reads everything but [arena]'s robots and [arena.ode]. Throws ConfigError.
EmulatorConfig read_emulator_config(const hal::Section& root);

}  // namespace arkmesh::emulator
