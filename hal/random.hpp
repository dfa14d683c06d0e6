// Named random streams from one seed. A stream's values depend on its name, the seed and how often it was asked, on
// nothing else; the standard library's distributions differ between implementations and are not used.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>

#include "hal/fixed_math.hpp"

namespace arkmesh::hal {

// SplitMix64's output function (Steele, Lea, Flood, OOPSLA 2014; constants of Stafford's variant 13).
constexpr std::uint64_t mix64(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

class RandomStream {
 public:
  // `name` is "lab/purpose"; robots have streams of their own: "lab/purpose/17" or (name, 17).
  RandomStream(std::uint64_t seed, std::string_view name, std::uint64_t index = 0) {
    std::uint64_t h = mix64(seed + 0x9e3779b97f4a7c15ULL);
    for (unsigned char c : name) h = mix64(h ^ c) + 0x9e3779b97f4a7c15ULL;
    key_ = mix64(h ^ mix64(index + 0x632be59bd9b4e019ULL));
  }
  std::uint64_t next() { return mix64(key_ + 0x9e3779b97f4a7c15ULL * ++count_); }
  // [0, 1)
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double from, double to) { return from + (to - from) * uniform(); }
  // 0..n-1, n > 0. The bias is below n / 2^64.
  std::uint64_t below(std::uint64_t n) {
    return static_cast<std::uint64_t>((static_cast<unsigned __int128>(next()) * n) >> 64);
  }
  // Normal, mean 0, standard deviation 1 (Box-Muller; two draws each).
  double normal() {
    const double u = 1.0 - uniform(), v = uniform();
    return std::sqrt(-2.0 * fixed::log(u)) * fixed::cos(2.0 * std::numbers::pi * v);
  }
  // How often it was asked; part of a lab's behaviour hash.
  std::uint64_t count() const { return count_; }

 private:
  std::uint64_t key_;
  std::uint64_t count_ = 0;
};

}  // namespace arkmesh::hal
