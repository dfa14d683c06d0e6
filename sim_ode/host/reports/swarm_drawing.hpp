// Pictures of a swarm's run, made by drawing/draw_swarm.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::sim_ode {

struct SwarmDrawing {
  std::string png, video;  // what to make, of the kinds that their endings say; nothing when both are empty
  std::string caption;     // words before the time
  double width_m = 1, height_m = 1;
  std::optional<hal::Pose> light;
  std::vector<hal::Obstacle> obstacles;
  std::vector<hal::MovableObject> objects;  // where they go is in the poses
};

// Draws the rows of `poses`, a file of PosesFile. Without it the script only says whether it could. Throws
// std::runtime_error with the script's own sentence about what it lacks.
void draw_swarm(const SwarmDrawing& drawing, const std::optional<std::filesystem::path>& poses);

}  // namespace arkmesh::sim_ode
