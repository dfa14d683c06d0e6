// See profile.hpp.
#include "tracker/detect/radial_profile.hpp"

#include <algorithm>
#include <cmath>

namespace arkmesh::tracker {
namespace {

constexpr std::size_t spokes = 48, of_ring = 16;  // each ring is looked at in every third direction

struct Directions {
  std::array<float, spokes> x{}, y{};
  Directions() {
    for (std::size_t i = 0; i < spokes; ++i) {
      const double angle = 6.283185307179586 * static_cast<double>(i) / spokes;
      x[i] = static_cast<float>(std::cos(angle)), y[i] = static_cast<float>(std::sin(angle));
    }
  }
};

// Grey levels without order.
template <std::size_t Most>
class Greys {
 public:
  void add(float value) { values_[count_++] = value; }
  // The value that this part of the others lies below; 0 of none. Asked for growing parts: what lies below is in order.
  float at(double part) {
    if (count_ == 0) return 0;
    const auto place = values_.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(count_ - 1) + 0.5);
    std::nth_element(values_.begin() + below_, place, end());
    below_ = place - values_.begin();
    return *place;
  }
  float deviation() {
    const float usual = at(0.5);
    for (auto value = values_.begin(); value != end(); ++value) *value = std::abs(*value - usual);
    below_ = 0;
    return at(0.5);
  }

 private:
  typename std::array<float, Most>::iterator end() { return values_.begin() + static_cast<std::ptrdiff_t>(count_); }
  std::array<float, Most> values_;
  std::size_t count_ = 0;
  std::ptrdiff_t below_ = 0;
};

}  // namespace

RadialProfile radial_profile(const DownsampledImage& patch, float x, float y, float r) {
  static const Directions towards;
  RadialProfile profile;
  const float max_x = static_cast<float>(patch.width) - 1.001F, max_y = static_cast<float>(patch.height) - 1.001F;
  // Where pixels are much smaller than what is looked at, the nearest one is as good as a mix of four.
  const bool nearest = r > 11;
  Greys<5 * of_ring> within, coin;
  Greys<2 * of_ring> board, outside;
  for (std::size_t ring = 0; ring < profile.rings.size(); ++ring) {
    const float far = (0.1F * static_cast<float>(ring) + 0.05F) * r;
    float sum = 0;
    int count = 0;
    for (std::size_t ray = ring % 2; ray < spokes; ray += spokes / of_ring) {
      const float px = x + far * towards.x[ray], py = y + far * towards.y[ray];
      if (!(px >= 0 && py >= 0 && px <= max_x && py <= max_y)) continue;
      const float value =
          nearest ? 0.125F * static_cast<float>(patch.row(static_cast<int>(py + 0.5F))[static_cast<int>(px + 0.5F)])
                  : patch.at(px, py);
      if (ring < 5) coin.add(value);
      if (ring < 9 && ring % 2 == 0) within.add(value);
      if (ring == 7 || ring == 8) board.add(value);
      if (ring > 10) outside.add(value);
      sum += value;
      ++count;
    }
    profile.rings[ring] = count ? sum / static_cast<float>(count) : 0;
  }
  // Median deviation: a glint or an LED alone does not count.
  profile.activity = within.deviation();
  const float coin_low = coin.at(0.1);
  profile.coin = coin.at(0.5);
  profile.coin_spread = coin.at(0.9) - coin_low;
  profile.board_low = board.at(0.1), profile.board = board.at(0.5), profile.board_high = board.at(0.9);
  profile.outside_low = outside.at(0.1), profile.outside_high = outside.at(0.9);
  return profile;
}

}  // namespace arkmesh::tracker
