#include "sim_ode/host/reports/swarm_drawing.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <vector>

#include "hal/platforms/kilobot/body.hpp"
#include "sim_ode/host/programs/subprocess.hpp"

namespace arkmesh::sim_ode {
namespace {

// As the script's --solid wants it, behind the name: pose, then radius or corners.
std::string described(const hal::Shape& shape, const hal::Pose& pose) {
  std::string out = fmt::format("{},{},{}:", pose.x_m, pose.y_m, pose.heading_rad);
  if (shape.corners.empty()) return out + fmt::format("{}", shape.radius_m);
  for (const hal::Point& corner : shape.corners) out += fmt::format("{},{},", corner.x_m, corner.y_m);
  out.pop_back();
  return out;
}

}  // namespace

void draw_swarm(const SwarmDrawing& drawing, const std::optional<std::filesystem::path>& poses) {
  if (drawing.png.empty() && drawing.video.empty()) return;
  const std::filesystem::path script = script_of_arkmesh("draw_swarm");
  std::vector<std::string> command = {script.string(), "--arena",
                                      fmt::format("{}x{}", drawing.width_m, drawing.height_m), "--diameter",
                                      fmt::format("{}", 2 * hal::kilobot::body_radius_m)};
  command.push_back(poses ? poses->string() : "--try");
  if (drawing.light) command.push_back(fmt::format("--light={},{}", drawing.light->x_m, drawing.light->y_m));
  for (const hal::Obstacle& obstacle : drawing.obstacles)
    command.push_back("--solid=:" + described(obstacle.shape, obstacle.pose));
  for (const hal::MovableObject& object : drawing.objects)
    command.push_back("--solid=" + object.name + ":" + described(object.shape, object.start));
  if (!drawing.png.empty()) command.insert(command.end(), {"--png", drawing.png});
  if (!drawing.video.empty()) command.insert(command.end(), {"--video", drawing.video});
  const Finished done = run_to_end(command);
  if (done.status == 0) return;
  std::string last = done.output;
  while (last.ends_with('\n')) last.pop_back();
  if (const auto line = last.rfind('\n'); line != std::string::npos) last.erase(0, line + 1);
  throw std::runtime_error(
      last.empty() ? fmt::format("{} cannot be started; it needs /usr/bin/python3", script.string()) : last);
}

}  // namespace arkmesh::sim_ode
