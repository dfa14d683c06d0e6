// An emulated testbed as an arena: the physical arena, unchanged, at cameras and an overhead controller that are
// computed in this process, in the emulated testbed's own time. Runs as fast as it can be computed, at most 20 ms of
// the emulator's time a call; equal seeds give equal runs.
#pragma once

#include <memory>
#include <string>

#include "emulator/emulator.hpp"
#include "hal/arenas/arena.hpp"
#include "hal/arenas/arena_row.hpp"
#include "hal/config/config.hpp"
#include "testbed/arena_monitor.hpp"

namespace arkmesh::emulator {

// [arena.emulated]
struct EmulatedConfig {
  std::filesystem::path file;  // of an emulator

  void fields(const hal::Section& emulated) {
    emulated.field("file", file,
                   {.help = "configuration file of the emulator",
                    .sample = "\"arkmesh:experiments/emulator/roark.toml\"",
                    .required = true});
  }
};

// Reads [arena.emulated]: `file` (required: an emulator's file, see `arkmesh emulator`), and [arena.kilobot] as the
// physical arena does; of its cameras only the calibration counts, camera k is the emulator's camera k. The emulator's
// seed becomes `seed`. Throws ConfigError.
std::unique_ptr<hal::Arena> make_emulated_arena(const hal::Section& arena, const std::string& lab, std::uint64_t seed,
                                                testbed::Observer observer);
hal::ArenaRow emulated_arena_row();

// The emulator of an arena that make_emulated_arena made, for tests and measurements that need its truth or its
// faults.
emulator::Emulator& emulator_of(hal::Arena& arena);

}  // namespace arkmesh::emulator
