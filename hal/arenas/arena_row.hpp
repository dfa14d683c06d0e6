// How a configuration becomes an arena: each kind of arena offers a row beside its own sources, app/arenas.cpp lists
// them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/arenas/picture_board.hpp"
#include "hal/bus/bus.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::hal {

// Who wants an arena, and what for.
struct ArenaRequest {
  RobotKind robot;         // what robots are in an arena that only stands for others
  std::string lab;         // its name
  std::uint64_t seed = 1;  // of the arena's random streams
  LabTime run_length{0};   // at least so much lab time will be asked for
  Bus* bus = nullptr;  // what it carries may be drawn over cameras' pictures; outlives the arena. Null: nobody watches
  PictureBoard* pictures = nullptr;            // shows what cameras see; outlives the arena. Null: nobody wants it
  std::filesystem::path directory;             // for videos
  bool set_up = false;                         // for a set-up procedure, which finds out itself who is who
  std::chrono::milliseconds hung_after{3000};  // without a sign of life of this program real robots are told to stand
  std::string program;  // what simulated robots run then: the name of a file in firmware/, or nothing
  // Refuses keys that nobody has read. Called by an arena that has read all of its own and goes on to something slow.
  std::function<void()> all_read = [] {};
};

struct ArenaRow {
  enum class Robots : std::uint8_t { none, simulated, real };  // whom a set-up procedure may talk to
  std::string name;                                            // what arena.use calls it
  std::vector<std::string> sections;                           // the [arena.NAME]s that it reads
  Robots robots;
  // Throws ConfigError. Null: known by name only, because the program was linked without it.
  std::function<std::unique_ptr<Arena>(const Section& arena, const ArenaRequest& request)> make;
  std::vector<KeyRow> (*keys)() = nullptr;  // of its sections, for the table of all keys
  // From the start of a message with words to single robots to the next, as that lab's file says; null: it has none.
  LabTime (*message_period)(const Section& arena) = nullptr;
  // The files that decide what its robots do, beside the configuration: their program; null: none. Those of a folder
  // are told one by one. Throws ConfigError.
  std::vector<std::filesystem::path> (*inputs)(const Section& arena) = nullptr;
};

}  // namespace arkmesh::hal
