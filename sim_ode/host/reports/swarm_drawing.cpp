#include "sim_ode/host/reports/swarm_drawing.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "hal/files/own_files.hpp"
#include "hal/platforms/kilobot/body.hpp"

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
  std::vector<std::string> words = {"--arena", fmt::format("{}x{}", drawing.width_m, drawing.height_m), "--diameter",
                                    fmt::format("{}", 2 * hal::kilobot::body_radius_m)};
  words.push_back(poses ? poses->string() : "--try");
  if (drawing.light) words.push_back(fmt::format("--light={},{}", drawing.light->x_m, drawing.light->y_m));
  for (const hal::Obstacle& obstacle : drawing.obstacles)
    words.push_back("--solid=:" + described(obstacle.shape, obstacle.pose));
  for (const hal::MovableObject& object : drawing.objects)
    words.push_back("--solid=" + object.name + ":" + described(object.shape, object.start));
  if (!drawing.caption.empty()) words.push_back("--caption=" + drawing.caption);
  if (!drawing.png.empty()) words.insert(words.end(), {"--png", drawing.png});
  if (!drawing.video.empty()) words.insert(words.end(), {"--video", drawing.video});
  hal::run_script("draw_swarm", std::move(words));
}

}  // namespace arkmesh::sim_ode
