// Proportions and colours after pictures of real robots; the parts' places are those that several of them share.
#include "emulator/robot_look.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "hal/platforms/kilobot/body.hpp"
#include "hal/random.hpp"

namespace arkmesh::emulator {
namespace {

struct Paint {
  float blue, green, red;
};

struct Kind {
  Paint cell, clip;
  double cell_radius, cell_ahead, cell_left, clip_turn, led_radius, tab_turn;
  std::uint64_t seed;
};

Kind kind_of(int kind, double cell_radius) {
  hal::RandomStream chance(7, "room/robot_look", static_cast<std::uint64_t>(kind));
  const auto around = [&chance](double middle, double off) { return chance.uniform(middle - off, middle + off); };
  Kind out;
  // steel, or bronze through its label
  out.cell = kind % 3 == 2 ? Paint{88, 102, 114} : Paint{112, 112, 116};
  const auto shade = static_cast<float>(around(1, 0.12));
  out.cell = {out.cell.blue * shade, out.cell.green * shade, out.cell.red * shade};
  out.clip = kind % 2 ? Paint{128, 128, 130} : Paint{84, 82, 80};
  out.cell_radius = around(cell_radius, 0.025);
  out.cell_ahead = around(-0.03, 0.03);
  out.cell_left = around(0.02, 0.03);
  out.clip_turn = around(0, 0.12);
  out.led_radius = around(hal::kilobot::led_radius_m / hal::kilobot::body_radius_m, 0.03);
  out.tab_turn = around(1.25, 0.08);
  out.seed = chance.next();
  return out;
}

bool in_box(double ahead, double left, double turn, double from, double to, double half_width) {
  const double along = ahead * std::cos(turn) + left * std::sin(turn),
               across = left * std::cos(turn) - ahead * std::sin(turn);
  return along > from && along < to && std::abs(across) < half_width;
}

Texture::Texel opaque(const Paint& paint, double shade = 1) {
  const auto s = static_cast<float>(shade);
  return {paint.blue * s, paint.green * s, paint.red * s, 1};
}

// The round board: dark solder mask, a darker edge, parts between rim and cell, the charging tab that sticks out at one
// side.
Texture::Texel board_at(const Kind& kind, double ahead, double left) {
  const double r = std::hypot(ahead, left);
  if (r > 1) {
    if (in_box(ahead, left, kind.tab_turn, 0.9, 1.13, 0.17)) return opaque({104, 106, 108});
    return {};
  }
  const double angle = std::atan2(left, ahead);
  if (r > 0.955) return opaque({30, 27, 26});
  // red capacitor ahead to the left, pale sensor to the right, small solder points behind
  if (in_box(ahead, left, 0.42, 0.84, 0.97, 0.13)) return opaque({48, 44, 112});
  if (in_box(ahead, left, -1.35, 0.83, 0.95, 0.12)) return opaque({122, 124, 124});
  if (in_box(ahead, left, kind.tab_turn, 0.8, 1, 0.15)) return opaque({92, 94, 96});
  for (double at : {2.5, 2.75, -2.6, -2.85, -0.35})
    if (std::hypot(ahead - 0.92 * std::cos(at), left - 0.92 * std::sin(at)) < 0.035) return opaque({150, 152, 152});
  // the mask, mottled by tracks
  const double mottle =
      1 + 0.16 * std::sin(9 * angle + static_cast<double>(kind.seed % 7)) * std::sin(17 * r + 5 * angle);
  return opaque({56, 42, 40}, mottle);
}

// The coin cell: a pale disc with a bright edge, brushed, and the spring clip that holds it.
Texture::Texel cell_at(const Kind& kind, double ahead, double left) {
  const double turn = kind.clip_turn;
  if (in_box(ahead, left, turn, 0.2, 0.93, 0.15))
    return opaque(kind.clip, in_box(ahead, left, turn, 0.2, 0.93, 0.05) ? 1.25 : 0.9);
  const double x = ahead - kind.cell_ahead, y = left - kind.cell_left, r = std::hypot(x, y) / kind.cell_radius;
  if (r > 1) return {};
  if (in_box(ahead, left, turn, 0.02, 0.16, 0.06) || in_box(ahead, left, turn, -0.16, -0.06, 0.07))
    return opaque({205, 206, 208});
  if (r > 0.94) return opaque(kind.cell, 0.7);
  if (r > 0.88) return opaque(kind.cell, 1.22);
  return opaque(kind.cell, 1 + 0.1 * std::cos(2 * std::atan2(y, x) + 1) * r - 0.06 * r);
}

Texture draw(const Kind& kind, Texture::Texel (*look)(const Kind&, double, double), double radius_px, double blur_px) {
  // three texels a pixel, but never so few that the parts vanish before the blur
  const double per_radius = std::clamp(3 * radius_px, 36.0, 200.0), blur = blur_px * per_radius / radius_px;
  const double half = 1.2 + 4 * blur_px / radius_px;
  constexpr int fine = 4;
  const int size = static_cast<int>(std::ceil(2 * half * per_radius));
  Texture out(size, static_cast<float>(size / (2 * per_radius)));
  cv::Mat layer(size, size, CV_32FC4);
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column) {
      cv::Vec4f sum(0, 0, 0, 0);
      for (int k = 0; k < fine * fine; ++k) {
        const double ahead = (column + (k % fine + 0.5) / fine) / per_radius - out.half(),
                     left = (row + (k / fine + 0.5) / fine) / per_radius - out.half();
        const Texture::Texel texel = look(kind, ahead, left);
        sum += cv::Vec4f(texel.blue, texel.green, texel.red, texel.cover);
      }
      layer.at<cv::Vec4f>(row, column) = sum / (fine * fine);
    }
  cv::GaussianBlur(layer, layer, {}, blur, blur, cv::BORDER_CONSTANT);
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column) {
      const cv::Vec4f& texel = layer.at<cv::Vec4f>(row, column);
      out.at(row, column) = {texel[0], texel[1], texel[2], texel[3]};
    }
  return out;
}

}  // namespace

RobotLook make_robot_look(int kind, double radius_px, double blur_px, double cell_radius) {
  const Kind look = kind_of(kind, cell_radius);
  // a pixel itself blurs as a box of one
  const double blur = std::sqrt(blur_px * blur_px + 1.0 / 12);
  return {draw(look, board_at, radius_px, blur), draw(look, cell_at, radius_px, blur), look.led_radius};
}

}  // namespace arkmesh::emulator
