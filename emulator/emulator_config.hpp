// The keys of an emulator's file: [emulator], [[emulator.camera]], [emulator.scene], [[emulator.event]]; its robots are
// in [arena] and [arena.ode].
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "emulator/camera.hpp"
#include "emulator/scene.hpp"
#include "hal/config/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::emulator {

struct EmulatorConfig {
  enum class Ids { in_order, shuffled, unassigned };
  // Something that happens by itself; `what` is as on the control port.
  struct Event {
    hal::LabTime at{0};
    std::string what;

    void fields(const hal::Section& event);
  };

  std::uint64_t seed = 1;
  double frames_per_s = 15;
  hal::LabTime frame_period{66'667};  // 1 / frames_per_s
  hal::LabTime exposure{10'000};
  Ids ids = Ids::shuffled;  // kilo_uid of the robots; "unassigned" is 65535 for all
  std::string listen = "127.0.0.1";
  std::uint16_t camera_port = 8090;  // 0: any free one
  std::uint16_t ohc_port = 8091;
  std::uint16_t nodes_port = 33333;
  std::uint16_t control_port = 8092;
  std::string ohc_link;  // a symbolic link to the pseudo-terminal, kept up to date; empty: none
  int jpeg_quality = 90;
  Scene scene;
  std::vector<CameraSettings> cameras;  // one at least
  std::vector<Event> events;            // ascending times

  void fields(const hal::Section& emulator);
};

// Reads everything but [arena]'s robots and [arena.ode]. Throws ConfigError.
EmulatorConfig read_emulator_config(const hal::Section& root);

}  // namespace arkmesh::emulator
