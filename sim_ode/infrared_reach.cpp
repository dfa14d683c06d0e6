#include "sim_ode/infrared_reach.hpp"

#include <algorithm>
#include <cmath>

#include "hal/random.hpp"

namespace arkmesh::sim_ode {

namespace {

// What own() draws of a robot; of_pair_m() has 0 and 1.
constexpr std::uint64_t strength = 4, gain = 5;

}  // namespace

double about_normal(std::uint64_t bits) {
  const auto sum = static_cast<double>((bits & 0xFFFF) + (bits >> 16 & 0xFFFF) + (bits >> 32 & 0xFFFF) + (bits >> 48));
  return (sum / 65536.0 - 2) * 1.7320508075688772;
}

InfraredReach::InfraredReach(const Settings& settings, const std::string& lab, std::uint64_t seed)
    : settings_(settings),
      pair_key_(hal::RandomStream(seed, lab + "/ode/infrared_pairs").next()),
      // two parts, each at most 3.47 s.d., that together are longest when even
      longest_m_(settings.ir_range_m + 3.47 * 1.4143 * settings.ir_range_spread_m) {}

void InfraredReach::set_gains(std::vector<float> gains) {
  if (std::ranges::all_of(gains, [](float gain) { return gain == 1; })) return;
  gains_ = std::move(gains);
  longest_m_ *= static_cast<double>(std::ranges::max(gains_));
}

double InfraredReach::of_pair_m(int from, int to) const {
  const double gain = gains_.empty() ? 1 : static_cast<double>(gains_[static_cast<std::size_t>(from)]);
  if (settings_.ir_range_spread_m == 0) return gain * settings_.ir_range_m;
  const auto normal = [this](int a, int b, std::uint64_t kind) {
    const auto pair = static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint64_t>(b);
    return about_normal(hal::mix64(hal::mix64(pair_key_ + kind) ^ hal::mix64(pair)));
  };
  const double both = normal(std::min(from, to), std::max(from, to), 0), own = normal(from, to, 1);
  // half of the variance is each direction's own: an assumption, see docs/model-truth.md
  return gain * (settings_.ir_range_m + settings_.ir_range_spread_m * (std::sqrt(0.5) * both + std::sqrt(0.5) * own));
}

std::uint64_t InfraredReach::own(int robot, std::uint64_t kind) const {
  return hal::mix64(hal::mix64(pair_key_ + kind) ^ hal::mix64(static_cast<std::uint64_t>(robot)));
}

double InfraredReach::measured_m(int from, int to, double distance_m) const {
  const AirSettings& air = settings_.air;
  double out = distance_m;
  if (air.ir_reading_spread > 0) {
    const double both = about_normal(own(from, strength)) + about_normal(own(to, gain));
    out *= std::max(0.0, 1 + air.ir_reading_spread * 0.7071067811865476 * both);
  }
  if (air.ir_flat_m > 0) {
    // straight to within 1 % up to 0.7 of it, 8 % short there
    const double share2 = out / air.ir_flat_m * (out / air.ir_flat_m), share4 = share2 * share2;
    out /= std::sqrt(std::sqrt(std::sqrt(1 + share4 * share4)));
  }
  return out;
}

bool InfraredReach::is_blocked(int from, int to, const ContactWorld& world) const {
  const auto place = [&](int robot) {
    const auto i = static_cast<std::size_t>(robot);
    return Point{world.x()[i], world.y()[i]};
  };
  return shadows_ && shadows_->between(place(from), place(to));
}

}  // namespace arkmesh::sim_ode
