#include "tests/examples/rover/simulated_rovers.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "tests/examples/rover/rover_arena.hpp"

namespace arkmesh::examples::rover {

SimulatedRovers::SimulatedRovers(const Settings& settings, hal::WallTime& wall)
    : wall_(wall), damage_(settings.damage), chance_(settings.seed, "rovers/chance"), drove_at_(wall.now()) {
  const double robots = std::max(1, settings.robots);
  const int columns =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(robots * settings.width_m / settings.height_m))));
  const int rows = std::max(1, static_cast<int>(std::ceil(robots / columns)));
  const double wide_m = settings.width_m / columns, high_m = settings.height_m / rows;
  for (int i = 0; i < settings.robots; ++i)
    circles_.push_back({(i % columns + 0.5) * wide_m - settings.width_m / 2,
                        (i / columns + 0.5) * high_m - settings.height_m / 2,
                        std::max(0.001, std::min(wide_m, high_m) / 2 - body_radius_m)});
}

void SimulatedRovers::write(std::span<const std::byte> bytes) {
  for (const Packet& packet : reader_.read(on_air(bytes))) perform(packet);
}

void SimulatedRovers::perform(const Packet& packet) {
  switch (packet.type) {
    case Packet::Type::tell:
      say({Packet::Type::answer, packet.robot, packet.kind, packet.value});
      break;
    case Packet::Type::show:
      lit_ = packet.robot;
      say({Packet::Type::shows, packet.robot});
      break;
    case Packet::Type::go:
    case Packet::Type::stand:
      drive();
      driving_ = packet.type == Packet::Type::go;
      for (std::size_t i = 0; !driving_ && i < circles_.size(); ++i)
        say({Packet::Type::stands, static_cast<std::uint16_t>(i)});
      break;
    default:  // what rovers say is not meant for them
      break;
  }
}

void SimulatedRovers::say(const Packet& packet) {
  if (packet.robot >= circles_.size()) return;
  const auto heard = on_air(encode(packet));
  to_base_.insert(to_base_.end(), heard.begin(), heard.end());
}

std::vector<std::byte> SimulatedRovers::on_air(std::span<const std::byte> bytes) {
  std::vector<std::byte> arrived(bytes.begin(), bytes.end());
  for (std::byte& byte : arrived)
    if (chance_.uniform() < damage_) byte ^= static_cast<std::byte>(1 + chance_.below(255));
  return arrived;
}

void SimulatedRovers::drive() {
  const hal::TimePoint now = wall_.now();
  if (driving_) driven_m_ += speed_m_s * std::chrono::duration<double>(now - drove_at_).count();
  drove_at_ = now;
}

hal::Pose SimulatedRovers::where(std::size_t robot) const {
  const Circle& circle = circles_.at(robot);
  const double angle = driven_m_ / circle.radius_m;
  const double heading = std::remainder(angle + std::numbers::pi / 2, 2 * std::numbers::pi);
  return {.x_m = circle.x_m + circle.radius_m * std::cos(angle),
          .y_m = circle.y_m + circle.radius_m * std::sin(angle),
          .heading_rad = heading > -std::numbers::pi ? heading : std::numbers::pi};
}

std::vector<Spot> SimulatedRovers::look() {
  drive();
  std::vector<Spot> spots;
  for (std::size_t i = 0; i < circles_.size(); ++i) spots.push_back({.pose = where(i), .lit = lit_ == i});
  // a camera does not know their numbers
  for (std::size_t i = spots.size(); i > 1; --i) std::swap(spots[i - 1], spots[chance_.below(i)]);
  return spots;
}

}  // namespace arkmesh::examples::rover
