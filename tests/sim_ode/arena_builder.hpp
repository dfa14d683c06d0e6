// Small ODE arenas for tests.
#pragma once

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "hal/config/config.hpp"
#include "sim_ode/ode_arena.hpp"

namespace arkmesh::sim_ode {

inline std::filesystem::path controller(const std::string& name) {
  return std::filesystem::path(ARKMESH_SOURCE_DIR) / "tests/sim_ode/controllers" / name;
}

struct TestArena {
  std::string program = "wander.c";  // a name in controllers/
  int robots = 1;
  double side_m = 1;
  std::string ode;    // further lines of [arena.ode]
  std::string arena;  // further lines of [arena]
  std::uint64_t seed = 1;
  std::string lab = "shark";

  std::unique_ptr<hal::Arena> make() const {
    const auto config = hal::Config::from_text(
        fmt::format(
            "[arena]\nwidth_m = {0}\nheight_m = {0}\nrobots = {1}\n{2}\n[arena.ode]\ncontroller = \"{3}\"\n{4}\n",
            side_m, robots, arena, controller(program).string(), ode),
        "test.toml");
    auto out = make_ode_arena(config.root().section("arena"), lab, seed);
    config.refuse_unknown();
    return out;
  }
  // Started at lab time 0: robots run from the tick after the first composite on.
  std::unique_ptr<hal::Arena> make_running() const {
    auto out = make();
    out->robots().command({.kind = hal::FleetCommand::Kind::run});
    return out;
  }
};

// A drive without spread: every robot does exactly what its motors are told.
inline const char* const exact_drive = "speed_spread = 0.0\nduty_spread = 0.0";

inline hal::LabTime seconds(double s) {
  return hal::LabTime{static_cast<std::int64_t>(s * 1e6 + 0.5)};
}

// Advances frame by frame and returns the frame at `t`, which must be a whole number of 0.1 s.
inline hal::PoseFrame frame_at(hal::Arena& arena, hal::LabTime t) {
  arena.advance_to(t);
  auto frame = arena.poses().latest();
  REQUIRE(frame);
  CHECK(frame->stamp == t);
  return *std::move(frame);
}

inline hal::FleetCommand broadcast(std::uint8_t type, std::initializer_list<int> data) {
  hal::FleetCommand out{.kind = hal::FleetCommand::Kind::broadcast, .type = type};
  std::size_t k = 0;
  for (int byte : data) out.data[k++] = static_cast<std::uint8_t>(byte);
  return out;
}

}  // namespace arkmesh::sim_ode
