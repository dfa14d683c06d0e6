// Runs a program of this folder on a swarm and keeps what tests ask for. For tests only.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim_ode/controller_swarm.hpp"
#include "sim_ode/host/reports/swarm_report.hpp"

namespace arkmesh::tests {

inline std::filesystem::path programs_folder() {
  return std::filesystem::path(ARKMESH_SOURCE_DIR) / "tests" / "programs";
}
inline std::filesystem::path program_file(const std::string& name) {
  return programs_folder() / (name + ".c");
}

inline double distance_m(const hal::Pose& a, const hal::Pose& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

// A row of robots along x.
inline std::vector<hal::Pose> row(int robots, double spacing_m, double x_m = 0, double y_m = 0,
                                  double heading_rad = 0) {
  std::vector<hal::Pose> places;
  for (int i = 0; i < robots; ++i) places.push_back({x_m + i * spacing_m, y_m, heading_rad});
  return places;
}

struct SwarmProgram {
  // Robots are those of the preset that ARKMESH_TEST_PRESET names, for who wants to know what holds with them.
  explicit SwarmProgram(const std::string& name) {
    options.program = program_file(name);
    if (const char* const preset = std::getenv("ARKMESH_TEST_PRESET"))
      options.settings.push_back(std::string("ode.preset=") + preset);
  }
  SwarmProgram(const std::string& name, std::vector<hal::Pose> places) : SwarmProgram(name) {
    options.robots = static_cast<int>(places.size());
    options.places = std::move(places);
  }

  sim_ode::SwarmOptions options;  // to be changed before the first for_seconds()
  sim_ode::SwarmReport report;
  std::optional<sim_ode::ControllerSwarm> swarm;
  std::string failure;                         // sentence of a program that does not run to the end
  bool refused = false;                        // it did not even start
  std::uint64_t hash = 14695981039346656037u;  // of all frames: places in micrometres, headings, colours

  // The next so many seconds; `look` sees each frame, 10 a second.
  void for_seconds(double seconds, const std::function<void(const hal::PoseFrame&)>& look = {}) {
    try {
      if (!swarm) swarm.emplace(options);
    } catch (const sim_ode::ProgramError& error) {
      refused = true;
      failure = error.what();
      return;
    }
    end_ += hal::LabTime(static_cast<std::int64_t>(seconds * 1e6));
    try {
      swarm->run_until(end_, [&](const hal::PoseFrame& frame) {
        report.look(frame);
        for (const hal::Observation& robot : frame.robots)
          for (const double value : {robot.pose.x_m, robot.pose.y_m, robot.pose.heading_rad})
            mix(static_cast<std::uint64_t>(std::llround(value * 1e6)) * 8 + static_cast<std::uint64_t>(robot.led));
        if (look) look(frame);
      });
    } catch (const std::runtime_error& error) {
      failure = error.what();
    }
  }
  std::uint64_t count(const char* name) const { return swarm ? swarm->arena().counters()[name] : 0; }
  const hal::Observation& robot(std::size_t i) const { return report.last().robots.at(i); }

 private:
  void mix(std::uint64_t word) {
    for (int i = 0; i < 8; ++i, word >>= 8) hash = (hash ^ (word & 0xFF)) * 1099511628211u;
  }
  hal::LabTime end_{0};
};

}  // namespace arkmesh::tests
