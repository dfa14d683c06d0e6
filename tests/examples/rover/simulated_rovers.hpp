// Rovers that nobody has built: what is at the other end of the cable and before the camera. They drive in circles,
// each in a square of its own, by wall time.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "hal/random.hpp"
#include "hal/time/wall_time.hpp"
#include "tests/examples/rover/devices.hpp"
#include "tests/examples/rover/protocol.hpp"

namespace arkmesh::examples::rover {

class SimulatedRovers final : public ByteStream, public SpotCamera {
 public:
  struct Settings {
    double width_m = 1, height_m = 1;  // of the arena
    int robots = 1;                    // ids 0..robots-1
    double damage = 0;                 // share of the bytes that are changed on their way, both ways
    std::uint64_t seed = 1;
  };
  explicit SimulatedRovers(const Settings& settings, hal::WallTime& wall = hal::machine_time());

  void write(std::span<const std::byte> bytes) override;
  std::vector<std::byte> read() override { return std::exchange(to_base_, {}); }
  std::vector<Spot> look() override;

 private:
  struct Circle {
    double x_m, y_m, radius_m;
  };
  void perform(const Packet& packet);
  void say(const Packet& packet);
  hal::Pose where(std::size_t robot) const;
  std::vector<std::byte> on_air(std::span<const std::byte> bytes);
  void drive();

  hal::WallTime& wall_;
  const double damage_;
  hal::RandomStream chance_;
  std::vector<Circle> circles_;  // by robot
  PacketReader reader_;
  std::vector<std::byte> to_base_;
  std::optional<std::uint16_t> lit_;
  bool driving_ = false;
  double driven_m_ = 0;  // by each of them
  hal::TimePoint drove_at_;
};

}  // namespace arkmesh::examples::rover
