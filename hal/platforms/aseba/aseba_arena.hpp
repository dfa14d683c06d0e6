// Robots that speak Aseba as an arena: cameras see them by the markers they carry, lines lead to their nodes. Cannot
// wait: lab time is real time.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/config/config.hpp"
#include "hal/platforms/aseba/nodes.hpp"
#include "hal/time/wall_time.hpp"

namespace arkmesh::hal::aseba {

// What sees the robots. Same thread as the arena.
class Eyes : public PoseSource {
 public:
  // Takes the newest pictures, as far as they have come. `now` is monotonic time since the arena was made. The arena
  // stamps and numbers the frames anew; ages are kept.
  virtual void look(LabTime now) = 0;
  // Robots that the newest pictures do not show, ascending.
  virtual const std::vector<RobotId>& missing() const = 0;
  // Why there are no pictures, one sentence; else empty.
  virtual std::string error() const = 0;
  virtual const Counters& counters() const = 0;
};

// [arena.aseba], but for the cameras. Throws ConfigError.
struct AsebaSettings {
  std::string connect;  // where nodes are: "tcp:HOST:PORT" or devices, with commas; "3 = /dev/ttyACM0": robot 3
  std::string make = "thymio";
  int first_id = 1;
  std::chrono::microseconds names_within{30'000'000};
  std::size_t may_miss = 0;
  double words_per_s = 100;
  ArenaInfo info;  // made of [arena] and the above

  void fields(const Section& aseba);
};
AsebaSettings read_aseba_settings(const Section& arena, const std::string& lab);

// The makes of robots that are known, by name.
const Make& make_of(const std::string& name);
const RobotKind& kind_of(const std::string& make);

// The lines that `connect` names, not open yet. Throws ConfigError.
std::vector<Connection> open_connections(const Section& aseba, const AsebaSettings& settings);

// advance_to(0) is there when every robot's node answers and its marker is seen, and throws std::runtime_error with
// what is missing when that takes longer than names_within. Afterwards it never throws. Destroying it before end() was
// true waits until it is. `wall`, when it is not the machine's, outlives the arena.
std::unique_ptr<Arena> make_aseba_arena(const AsebaSettings& settings, std::vector<Connection> connections,
                                        std::unique_ptr<Eyes> eyes, WallTime& wall = machine_time());

}  // namespace arkmesh::hal::aseba
