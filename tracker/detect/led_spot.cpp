// See led_spot.hpp.
#include "tracker/detect/led_spot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <tuple>
#include <utility>

#include "tracker/detect/led_colour.hpp"
#include "tracker/detect/led_neighbours.hpp"
#include "tracker/detect/white_balance.hpp"

namespace arkmesh::tracker {
namespace {

constexpr int directions = 48, rings = 8;
constexpr double nearest = 0.6, ring_step = 0.06;  // of the radius: the LED lies at 0.8 to 0.95, parallax included
constexpr double two_pi = 6.283185307179586;
constexpr double cold_bonus = 0.12, lit = 0.98;  // least brightness of a spot that is lit, see below
// Most that a coin cell lets guess of white, and that coloured light must outshine: the mean of a lit spot is darker
// than its brightest pixel. Chosen on real pictures with glare painted on and on white arenas: with 255, more than a
// quarter of their lit LEDs stay off.
constexpr double most_white = 190;
// Boards are darker than this part of arena or coin cell, and than this, or else the picture is hazy: chosen on real
// pictures of little contrast and on dark arenas.
constexpr double darkest_part = 0.6, darkest = 60;
// Metal and coin cells that mirror a lamp are warm and pale, and seldom outshine a white arena by much: chosen on
// rendered rooms.
constexpr double palest_warm = 0.4, surely_lit = 0.55;
// Where an LED's light can be. Nearer to the centre it is a reflection or a part of the board, farther out a
// neighbour's LED: 8 of 7000 lit LEDs in the bench's pictures and in rendered rooms appear outside these limits.
constexpr double too_near = 0.7, too_far = 1.1;
// The weight of a pixel one of whose channels is cut off, which turns its hue: webcams see the middle of a green LED
// cyan and only its halo green. Chosen on rendered rooms with webcams and on real pictures with noise and casts.
constexpr float cut_off = 0.1F;
constexpr double smallest_r_px = 10;  // below it halos are as pale; chosen on the real pictures with noise

struct RingDirections {
  std::array<float, directions> x{}, y{};
  RingDirections() {
    for (std::size_t i = 0; i < directions; ++i) {
      x[i] = static_cast<float>(std::cos(two_pi * static_cast<double>(i) / directions));
      y[i] = static_cast<float>(std::sin(two_pi * static_cast<double>(i) / directions));
    }
  }
};

// The picture in rings round the robot: colour and brightest channel of ring d in direction a.
struct Rings {
  std::array<std::array<std::array<std::uint8_t, 3>, directions>, rings> colour;
  std::array<std::array<int, directions>, rings> value;
  std::array<int, rings> usual;  // median of value in each ring
};

// Pixels of a picture by place; places outside it give the nearest pixel inside.
class Pixels {
 public:
  // All places asked for lie within `reach` of (x, y).
  Pixels(const cv::Mat& bgr, double x, double y, double reach)
      : data_(bgr.data),
        line_(bgr.step[0]),
        columns_(bgr.cols),
        rows_(bgr.rows),
        inside_(x - reach >= 0 && y - reach >= 0 && x + reach < bgr.cols - 1 && y + reach < bgr.rows - 1) {}
  const std::uint8_t* at(float x, float y) const {
    int column = 0, row = 0;
    if (inside_)
      column = static_cast<int>(x + 0.5F), row = static_cast<int>(y + 0.5F);
    else {
      column = static_cast<int>(std::clamp(x + 0.5F, 0.0F, static_cast<float>(columns_ - 1)));
      row = static_cast<int>(std::clamp(y + 0.5F, 0.0F, static_cast<float>(rows_ - 1)));
    }
    return data_ + static_cast<std::size_t>(row) * line_ + 3 * static_cast<std::size_t>(column);
  }

 private:
  const std::uint8_t* data_;
  std::size_t line_;
  int columns_, rows_;
  bool inside_;
};

int brightest_channel(const std::uint8_t* bgr) {
  return std::max(bgr[0], std::max(bgr[1], bgr[2]));
}

// Of every other value: as good, and half the work.
int median(const std::array<int, directions>& values) {
  std::array<int, directions / 2> half;
  for (std::size_t i = 0; i < half.size(); ++i) half[i] = values[2 * i];
  std::nth_element(half.begin(), half.begin() + directions / 4, half.end());
  return half[directions / 4];
}

// What the board looks like without the LED's light: the mean of its darkest third.
Light dark_board(const Rings& seen) {
  std::array<int, 256> count{};
  for (std::size_t d = 2; d < 7; ++d)
    for (const int value : seen.value[d]) ++count[static_cast<std::size_t>(value)];
  int limit = 0;
  for (int sum = 0; limit < 255; ++limit)
    if ((sum += count[static_cast<std::size_t>(limit)]) >= 5 * directions / 3) break;
  Light mean;
  int pixels = 0;
  for (std::size_t d = 2; d < 7; ++d)
    for (std::size_t a = 0; a < directions; ++a) {
      if (seen.value[d][a] > limit) continue;
      mean.blue += seen.colour[d][a][0], mean.green += seen.colour[d][a][1], mean.red += seen.colour[d][a][2];
      ++pixels;
    }
  return {mean.blue / pixels, mean.green / pixels, mean.red / pixels};
}

std::pair<hal::Led, float> primary_of(const Light& added) {
  std::array<std::pair<double, hal::Led>, 3> light{
      {{added.red, hal::Led::red}, {added.green, hal::Led::green}, {added.blue, hal::Led::blue}}};
  std::stable_sort(light.begin(), light.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  if (!(light[0].first > 0)) return {hal::Led::off, 0.0F};
  return {light[0].second, static_cast<float>(1 - std::max(light[1].first, 0.0) / light[0].first)};
}

}  // namespace

LedSpot find_led(const cv::Mat& bgr, const Circle& board, const Light& gains) {
  static const RingDirections towards;
  const double none = std::numeric_limits<double>::quiet_NaN();
  const double r_px = board.r_px;
  LedSpot spot{.x_px = none, .y_px = none};
  if (!(r_px >= 2 && std::abs(board.x_px) < 1e6 && std::abs(board.y_px) < 1e6 && r_px < 1e6)) return spot;

  const Pixels pixels(bgr, board.x_px, board.y_px, 1.25 * r_px);
  const auto middle_x = static_cast<float>(board.x_px), middle_y = static_cast<float>(board.y_px),
             r = static_cast<float>(r_px);
  const auto at = [&](float far, std::size_t direction) {
    return pixels.at(middle_x + far * towards.x[direction], middle_y + far * towards.y[direction]);
  };
  Rings seen;
  std::array<int, directions> arena{};
  for (std::size_t d = 0; d < rings; ++d) {
    const float far = static_cast<float>(nearest + ring_step * static_cast<double>(d)) * r;
    for (std::size_t a = 0; a < directions; ++a) {
      const std::uint8_t* pixel = at(far, a);
      seen.colour[d][a] = {pixel[0], pixel[1], pixel[2]};
      seen.value[d][a] = brightest_channel(pixel);
    }
    seen.usual[d] = median(seen.value[d]);
  }
  for (std::size_t a = 0; a < directions; ++a) arena[a] = brightest_channel(at(1.2F * r, a));

  // The spot: 3 x 3 samples that stand out most from the rest of their rings; and the best elsewhere on the robot.
  std::array<std::array<int, directions>, rings - 2> stands_out;
  int most = -1;
  std::size_t spot_ring = 1, spot_direction = 0;
  for (std::size_t d = 1; d + 1 < rings; ++d) {
    std::array<int, directions> column;
    for (std::size_t a = 0; a < directions; ++a)
      column[a] = seen.value[d - 1][a] + seen.value[d][a] + seen.value[d + 1][a];
    const int usual = 3 * (seen.usual[d - 1] + seen.usual[d] + seen.usual[d + 1]);
    for (std::size_t a = 0; a < directions; ++a) {
      const int excess = column[(a + directions - 1) % directions] + column[a] + column[(a + 1) % directions] - usual;
      stands_out[d - 1][a] = excess;
      if (excess > most) most = excess, spot_ring = d, spot_direction = a;
    }
  }
  const int spot_value = most + 3 * (seen.usual[spot_ring - 1] + seen.usual[spot_ring] + seen.usual[spot_ring + 1]);
  int elsewhere = 0;
  for (std::size_t turn = 7; turn <= directions - 7; ++turn) {
    const std::size_t a = (spot_direction + turn) % directions;
    for (const auto& ring : stands_out) elsewhere = std::max(elsewhere, ring[a]);
  }
  const double peak = spot_value / 9.0, excess = most / 9.0;
  const double far = (nearest + ring_step * static_cast<double>(spot_ring)) * r_px;
  double x = board.x_px + far * static_cast<double>(towards.x[spot_direction]);
  double y = board.y_px + far * static_cast<double>(towards.y[spot_direction]);

  // How bright a white thing is here, above haze: the arena, or on a dark arena what the coin cell lets guess.
  std::array<int, directions> coin{};
  for (std::size_t a = 0; a < directions; ++a) coin[a] = brightest_channel(at(0.35F * r, a));
  const Light dark = dark_board(seen);
  const double arena_value = median(arena), coin_value = median(coin);
  const double haze = std::max(0.0, std::max({dark.blue, dark.green, dark.red}) -
                                        std::max(darkest, darkest_part * std::max(arena_value, coin_value))) /
                      (1 - darkest_part);
  const double white = std::max({arena_value - haze, std::min(1.6 * (coin_value - haze), most_white), 20.0});

  // Core and halo, pixel by pixel.
  const auto dark_blue = static_cast<float>(dark.blue), dark_green = static_cast<float>(dark.green),
             dark_red = static_cast<float>(dark.red);
  const auto core_level = static_cast<float>(peak - 0.4 * excess), reach = static_cast<float>(0.5 * r_px),
             r_squared = static_cast<float>(r_px * r_px);
  const float halo = 1 / (0.36F * r_squared), core_squared = 0.1F * r_squared;
  const int from_y = std::max(0, static_cast<int>(y) - static_cast<int>(reach)),
            to_y = std::min(bgr.rows - 1, static_cast<int>(y + reach) + 1);
  const auto by_blue = static_cast<float>(gains.blue), by_green = static_cast<float>(gains.green),
             by_red = static_cast<float>(gains.red);
  // With less gain than the others, a cut-off channel would look darker than it is.
  const int most_blue = gains.blue < 1 ? most_certain : 255, most_red = gains.red < 1 ? most_certain : 255;
  float core_x = 0, core_y = 0, core_weight = 0, added_blue = 0, added_green = 0, added_red = 0;
  for (int row = from_y; row <= to_y; ++row) {
    const std::uint8_t* line = bgr.ptr<std::uint8_t>(row);
    const float dy = static_cast<float>(row - y), out_y = static_cast<float>(row - board.y_px);
    if (dy * dy > reach * reach) continue;
    const double half = std::sqrt(reach * reach - dy * dy);
    const int from_x = std::max(0, static_cast<int>(std::ceil(x - half))),
              to_x = std::min(bgr.cols - 1, static_cast<int>(std::floor(x + half)));
    for (int column = from_x; column <= to_x; ++column) {
      const std::uint8_t* pixel = line + 3 * column;
      const float dx = static_cast<float>(column - x), squared = dx * dx + dy * dy;
      const auto value = static_cast<float>(brightest_channel(pixel));
      if (value > core_level && squared < core_squared) {
        const float weight = value - core_level;
        core_x += weight * dx, core_y += weight * dy, core_weight += weight;
      }
      const float blue = (pixel[0] - dark_blue) * by_blue, green = (pixel[1] - dark_green) * by_green,
                  red = (pixel[2] - dark_red) * by_red;
      const float bright = std::max(blue, std::max(green, red));
      const float out_x = static_cast<float>(column - board.x_px);
      if (bright < 8 || out_x * out_x + out_y * out_y > r_squared ||
          std::min(pixel[0], std::min(pixel[1], pixel[2])) >= 240 || pixel[0] > most_blue || pixel[2] > most_red)
        continue;
      const float colour = bright - std::min(blue, std::min(green, red));
      const float nearness = 1 - squared * halo;  // reach keeps it positive
      const float near = nearness * nearness * nearness,
                  weight = colour * colour * near * (value > most_certain ? cut_off : 1);
      added_blue += weight * blue, added_green += weight * green, added_red += weight * red;
    }
  }
  const Light added{static_cast<double>(added_blue), static_cast<double>(added_green), static_cast<double>(added_red)};
  // A lit spot outshines the arena, if it is coloured only as far as most_white, and all other spots on the robot;
  // glints on unlit robots do neither much, and have the warm or grey colour of metal. The weights separate lit from
  // unlit robots of real pictures, changed in light, noise, blur and size.
  const LedColour colour = led_colour(added);
  std::tie(spot.primary, spot.primary_confidence) = primary_of(added);
  const bool cold = colour.led == hal::Led::green || colour.led == hal::Led::cyan || colour.led == hal::Led::blue;
  const double max_added = std::max({added.blue, added.green, added.red, 1e-9});
  const double saturation = (max_added - std::min({added.blue, added.green, added.red})) / max_added;
  // metal is warm, but never that colourful
  const double vivid = std::clamp((saturation - 0.6) / 0.25, 0.0, 1.0);
  const double bonus = cold_bonus * (cold ? 1.0 : vivid) * colour.confidence;
  const double outshone = colour.led == hal::Led::white ? white : std::min(white, most_white);
  const double brightness = (peak - haze + 0.17 * excess - 0.45 * elsewhere / 9.0) / outshone + bonus;
  const auto sure = static_cast<float>(std::clamp(std::abs(brightness - lit) / 0.2, 0.0, 1.0));
  spot.lit_confidence = sure;
  if (brightness < lit) {
    if (sure < least_sure)
      spot.led = hal::Led::unknown, spot.lit_confidence = 0;
    else
      spot.confidence = sure;
    return spot;
  }
  spot.led = colour.led;
  spot.hue_deg = colour.hue_deg;
  spot.confidence = std::min(sure, colour.confidence);
  if (core_weight > 0) {
    x += static_cast<double>(core_x / core_weight);
    y += static_cast<double>(core_y / core_weight);
  }
  // so light is no LED's if it is pale and warm, and either weak or where no LED is
  const double off = std::hypot(x - board.x_px, y - board.y_px) / r_px;
  if (off < too_near || off > too_far ||
      (r_px > smallest_r_px && (colour.led == hal::Led::red || colour.led == hal::Led::yellow) &&
       saturation < palest_warm && (sure < surely_lit || off < nearest_led)))
    return {hal::Led::unknown, 0, 0, 0, none, none, spot.primary, spot.primary_confidence};
  spot.x_px = x, spot.y_px = y;
  return spot;
}

}  // namespace arkmesh::tracker
