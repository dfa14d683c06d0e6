// The keys of a room's file: [room], [[room.camera]], [room.scene], [[room.event]]; its robots are in [arena] and
// [arena.ode].
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "emulator/camera.hpp"
#include "emulator/scene.hpp"
#include "hal/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::emulator {

struct RoomConfig {
  enum class Ids { in_order, shuffled, unassigned };
  // Something that happens by itself; `what` is as on the control port.
  struct Event {
    hal::LabTime at{0};
    std::string what;
  };

  std::uint64_t seed = 1;             // room.seed
  hal::LabTime frame_period{66'667};  // 1 / room.frames_per_s, 15
  hal::LabTime exposure{10'000};      // room.exposure_s
  Ids ids = Ids::shuffled;            // room.ids: kilo_uid of the robots; "unassigned" is 65535 for all
  std::string listen = "127.0.0.1";   // room.listen
  std::uint16_t camera_port = 8090;   // room.camera_port, 0 any free one
  std::uint16_t ohc_port = 8091;      // room.ohc_port
  std::uint16_t control_port = 8092;  // room.control_port
  std::string ohc_link;   // room.ohc_link: a symbolic link to the pseudo-terminal, kept up to date; empty: none
  int jpeg_quality = 90;  // room.jpeg_quality
  Scene scene;
  std::vector<CameraSettings> cameras;  // one at least
  std::vector<Event> events;            // ascending times
};

// Reads everything but [arena]'s robots and [arena.ode]. Throws ConfigError.
RoomConfig read_room_config(const hal::Section& root);

}  // namespace arkmesh::emulator
