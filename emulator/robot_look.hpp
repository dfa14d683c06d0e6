// What a Kilobot looks like from above, as textures that a camera samples: the board with its rim, parts and charging
// tab; the coin cell above it. Drawn once for each camera and kind of robot, blurred as the camera's lens and pixels
// blur.
#pragma once

#include <cstdint>
#include <vector>

namespace arkmesh::emulator {

// Colours are multiplied by the cover already. Square, centred; at robot frame (ahead, left) in radii of the robot.
class Texture {
 public:
  struct Texel {
    float blue, green, red, cover;
  };
  // `half` is the side's half length in radii.
  Texture(int size, float half)
      : size_(size),
        half_(half),
        scale_(static_cast<float>(size) / (2 * half)),
        texels_(static_cast<std::size_t>(size * size)) {}

  int size() const { return size_; }
  float half() const { return half_; }
  Texel& at(int row, int column) { return texels_[static_cast<std::size_t>(row * size_ + column)]; }
  // Between the four texels around; nothing covers outside.
  Texel sample(float ahead, float left) const {
    const float u = (ahead + half_) * scale_ - 0.5F, v = (left + half_) * scale_ - 0.5F;
    if (!(u >= 0 && v >= 0 && u < static_cast<float>(size_ - 1) && v < static_cast<float>(size_ - 1))) return {};
    const int column = static_cast<int>(u), row = static_cast<int>(v);
    const float a = u - static_cast<float>(column), b = v - static_cast<float>(row);
    const Texel* const top = &texels_[static_cast<std::size_t>(row * size_ + column)];
    const Texel* const below = top + size_;
    const float w00 = (1 - a) * (1 - b), w01 = a * (1 - b), w10 = (1 - a) * b, w11 = a * b;
    return {w00 * top[0].blue + w01 * top[1].blue + w10 * below[0].blue + w11 * below[1].blue,
            w00 * top[0].green + w01 * top[1].green + w10 * below[0].green + w11 * below[1].green,
            w00 * top[0].red + w01 * top[1].red + w10 * below[0].red + w11 * below[1].red,
            w00 * top[0].cover + w01 * top[1].cover + w10 * below[0].cover + w11 * below[1].cover};
  }

 private:
  int size_;
  float half_, scale_;
  std::vector<Texel> texels_;
};

// One of a few kinds: robots of a real swarm differ in cells, solder and LED places.
struct RobotLook {
  Texture board, cell;
  double led_radius;  // of the robot's radius
};

inline constexpr int robot_kinds = 6;

// `radius_px` is a robot's radius in the picture, `blur_px` the s.d. of the camera's blur; `cell_radius` is that of the
// coin cells of most robots, as a part of a robot's radius.
RobotLook make_robot_look(int kind, double radius_px, double blur_px, double cell_radius);

}  // namespace arkmesh::emulator
