// Arguments are reduced as Cody and Waite do, for large angles as Payne and Hanek do; the rest are polynomials near
// the best. Pairs carry what one double cannot hold. Square roots and ldexp are exact everywhere.
#include "hal/fixed_math.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

namespace arkmesh::hal::fixed {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double tiny = 0x1p-27;  // what is smaller is its own sine, arc tangent, ...

// The sum of both, of which `hi` is the nearest double.
struct Pair {
  double hi = 0, lo = 0;
};
constexpr Pair pi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
constexpr Pair half_pi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
constexpr Pair quarter_pi{0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55};
constexpr Pair two_thirds{0x1.5555555555555p-1, 0x1.5555555555555p-55};
constexpr Pair third{0x1.5555555555555p-2, 0x1.5555555555555p-56};
constexpr Pair per_ln10{0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57};
constexpr Pair per_ln2{0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56};
// Few bits first, so that a product with a small whole number is exact.
constexpr double half_pi_1 = 0x1.921fb544p+0, half_pi_2 = 0x1.0b4611a6p-34, half_pi_3 = 0x1.3198a2e037073p-69;
constexpr double ln2_1 = 0x1.62e42feep-1, ln2_2 = 0x1.a39ef35793c76p-33;

// Exact; |a| >= |b|.
Pair quick_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}
// Exact.
Pair sum(double a, double b) {
  const double s = a + b, of_b = s - a;
  return {s, (a - (s - of_b)) + (b - of_b)};
}
// Exact, below 2^900.
Pair product(double a, double b) {
  const double p = a * b, wide_a = a * 134217729.0, wide_b = b * 134217729.0;
  const double a1 = wide_a - (wide_a - a), b1 = wide_b - (wide_b - b), a2 = a - a1, b2 = b - b1;
  return {p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2};
}
Pair product(Pair a, Pair b) {
  const Pair p = product(a.hi, b.hi);
  return quick_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

// Coefficients from the constant on.
template <std::size_t n>
double polynomial(const std::array<double, n>& coefficients, double x) {
  double out = coefficients[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) out = out * x + coefficients[i];
  return out;
}

double nearest_whole(double x) {
  return (x + 0x1.8p52) - 0x1.8p52;
}

// ---- angles ----

// An angle less a multiple of a right angle, of which only the remainder of 4 is kept; at most an eighth of a turn.
struct Angle {
  Pair rest;
  unsigned right_angles = 0;
};

// 2/pi as bits, the first of which stands for 2^63.
constexpr std::array<std::uint64_t, 20> two_per_pi{
    0x0000000000000000, 0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561,
    0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e, 0xe88235f52ebb4484, 0xe99c7026b45f7e41,
    0x3991d639835339f4, 0x9c845f8bbdf9283b, 0x1ff897ffde05980f, 0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7,
    0x4f463f669e5fea2d, 0x7527bac7ebe5f17b, 0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab};

// From 2^20 on: 192 bits of the product with 2/pi, from the one that stands for 2 on; those above are whole turns.
Angle reduce_large(double x) {
  using Wide = unsigned __int128;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const std::uint64_t mantissa = (bits & 0x000f'ffff'ffff'ffff) | 0x0010'0000'0000'0000;
  const auto exponent = static_cast<int>(bits >> 52 & 0x7ff) - 1075;
  const auto from = static_cast<std::size_t>(exponent + 62);
  const auto word = [&](std::size_t i) {
    const std::size_t at = from / 64 + i, shift = from % 64;
    return shift == 0 ? two_per_pi[at] : two_per_pi[at] << shift | two_per_pi[at + 1] >> (64 - shift);
  };
  const Wide low = Wide{mantissa} * word(2), middle = Wide{mantissa} * word(1) + (low >> 64);
  std::uint64_t top = mantissa * word(0) + static_cast<std::uint64_t>(middle >> 64);
  Wide rest = middle << 64 | static_cast<std::uint64_t>(low);

  auto right_angles = static_cast<unsigned>(top >> 62);
  top = top << 2 | static_cast<std::uint64_t>(rest >> 126);
  rest <<= 2;
  const bool above_half = top >> 63 != 0;
  if (above_half) {
    rest = -rest;
    top = ~top + (rest == 0 ? 1 : 0);
    ++right_angles;
  }
  const int zeros = top != 0 ? std::countl_zero(top) : 64;
  if (zeros == 64) {
    top = static_cast<std::uint64_t>(rest >> 64), rest <<= 64;
  } else if (zeros > 0) {
    top = top << zeros | static_cast<std::uint64_t>(rest >> (128 - zeros));
    rest <<= zeros;
  }
  const std::uint64_t next = top << 53 | static_cast<std::uint64_t>(rest >> 75);
  const double hi = std::ldexp(static_cast<double>(top >> 11), -53 - zeros),
               lo = std::ldexp(static_cast<double>(next), -117 - zeros);
  const Pair angle = product(quick_sum(hi, lo), half_pi);
  if (x < 0) right_angles = 4 - right_angles;
  return above_half != (x < 0) ? Angle{{-angle.hi, -angle.lo}, right_angles % 4} : Angle{angle, right_angles % 4};
}

Angle reduce(double x) {
  const double size = std::abs(x);
  if (size <= quarter_pi.hi) return {{x, 0}, 0};
  if (size >= 0x1p20) return reduce_large(x);
  const double k = nearest_whole(x * (2 / half_pi.hi / 2));
  const Pair first = sum(x - k * half_pi_1, -(k * half_pi_2));
  const Pair second = sum(first.hi, -(k * half_pi_3));
  return {quick_sum(second.hi, second.lo + first.lo), static_cast<unsigned>(static_cast<int>(k)) % 4};
}

constexpr std::array sine{-0x1.5555555555555p-3, 0x1.1111111110ba5p-7,   -0x1.a01a019e8069ap-13,
                          0x1.71de3792528abp-19, -0x1.ae60069ee3ecfp-26, 0x1.5e09858a97437p-33};
constexpr std::array cosine{0x1.5555555555555p-5,   -0x1.6c16c16c16960p-10, 0x1.a01a019f4d0f0p-16,
                            -0x1.27e4fa15bdc69p-22, 0x1.1eeb66b6cb12cp-29,  -0x1.907c0e977e8bdp-37};

// Of an eighth of a turn at most.
Pair small_sine(Pair x) {
  const double z = x.hi * x.hi;
  return quick_sum(x.hi, x.hi * z * polynomial(sine, z) + x.lo * (1 - 0.5 * z));
}
Pair small_cosine(Pair x) {
  const double z = x.hi * x.hi, half = 0.5 * z, most = 1 - half;
  return quick_sum(most, ((1 - most) - half) + (z * z * polynomial(cosine, z) - x.hi * x.lo));
}

// Of the angle and `more` right angles.
double sine_of(const Angle& angle, unsigned more = 0) {
  const unsigned right_angles = angle.right_angles + more;
  const double size = right_angles % 2 == 0 ? small_sine(angle.rest).hi : small_cosine(angle.rest).hi;
  return right_angles & 2 ? -size : size;
}

constexpr std::array arc_tangent{-0x1.5555555555553p-2, 0x1.9999999998777p-3,  -0x1.24924923a5e38p-3,
                                 0x1.c71c713067623p-4,  -0x1.745cfe8a859c3p-4, 0x1.3b115009b2a9cp-4,
                                 -0x1.10ec41dcf4a5bp-4, 0x1.defe280ed77a1p-5,  -0x1.9c223670905aap-5,
                                 0x1.353a0671c05bap-5,  -0x1.1e1933d963041p-6};

// The angle whose tangent is x >= 0: one that is known, and a small rest.
double arc(double x) {
  Pair known;
  double t = x;
  if (x < tiny) return x;
  if (x >= 0x1.38p1)
    known = half_pi, t = -1 / x;
  else if (x >= 0x1.3p0)
    known = {0x1.f730bd281f69bp-1, 0x1.007887af0cbbdp-56}, t = (x - 1.5) / (1 + 1.5 * x);
  else if (x >= 0x1.6p-1)
    known = quarter_pi, t = (x - 1) / (x + 1);
  else if (x >= 0x1.cp-2)
    known = {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56}, t = (2 * x - 1) / (2 + x);
  const double z = t * t;
  return known.hi + (t + (known.lo + t * z * polynomial(arc_tangent, z)));
}

constexpr std::array arc_sine{0x1.5555555555556p-3, 0x1.3333333332ecap-4, 0x1.6db6db6e31f13p-5, 0x1.f1c71c1db0623p-6,
                              0x1.6e8bb1c8209a2p-6, 0x1.1c4d35cf95421p-6, 0x1.c9cf07674736ap-7, 0x1.782651caa6547p-7,
                              0x1.52420b04b37bep-7, 0x1.65a9c4dfcf8b2p-8, 0x1.1d189408314eep-6, -0x1.e6aaa8a0a04ccp-7,
                              0x1.d72b2bc8155f8p-6};

// Of 0.5 at most, less x: x^3/6 + ...
double arc_sine_above(double x) {
  const double z = x * x;
  return x * z * polynomial(arc_sine, z);
}
// acos(x) from 0.5 on.
double steep_arc_cosine(double x) {
  const double half = std::sqrt(0.5 * (1 - x));
  return 2 * (half + arc_sine_above(half));
}

// ---- powers ----

// x * 2^exponent, x from 0.5 to 2.
double scale(double x, int exponent) {
  if (exponent < -1020 || exponent > 1020) return std::ldexp(x, exponent);
  return x * std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
}

constexpr std::array exponential{0x1.0000000000000p-1,  0x1.5555555555555p-3,  0x1.5555555555557p-5,
                                 0x1.1111111111111p-7,  0x1.6c16c16c15a48p-10, 0x1.a01a01a01969bp-13,
                                 0x1.a01a01a9f72adp-16, 0x1.71de3a5aaefb9p-19, 0x1.27e4d3f50d87fp-22,
                                 0x1.ae642c5c1fa33p-26, 0x1.1f7f6aa421dd8p-29, 0x1.61bff1c64f494p-33};

double power_of_e(Pair x) {
  if (x.hi > 710) return infinity;
  if (x.hi < -746) return 0;
  const double k = nearest_whole(x.hi * per_ln2.hi);
  const Pair r = sum(x.hi - k * ln2_1, x.lo - k * ln2_2);
  const Pair most = quick_sum(1, r.hi);
  const double rest = r.hi * r.hi * polynomial(exponential, r.hi) + r.lo * (1 + r.hi);
  return scale(most.hi + (most.lo + rest), static_cast<int>(k));
}

// x = 2^exponent * (1 + above), between the square roots of 1/2 and 2. Finite, above 0.
struct Scaled {
  double exponent = 0, above = 0;
};
Scaled scaled(double x) {
  const int below = x < 0x1p-1022 ? 54 : 0;  // what has fewer bits gets all of them
  const auto bits = std::bit_cast<std::uint64_t>(below > 0 ? x * 0x1p54 : x);
  int exponent = static_cast<int>(bits >> 52) - 1022 - below;
  double mantissa = std::bit_cast<double>((bits & 0x000f'ffff'ffff'ffff) | 0x3fe0'0000'0000'0000);  // from 0.5 on
  if (mantissa < std::numbers::sqrt2 / 2) mantissa *= 2, --exponent;
  return {static_cast<double>(exponent), mantissa - 1};
}

// (log((1 + s) / (1 - s)) / s - 2 - 2/3 s^2) / s^4, by s^2.
constexpr std::array logarithm{0x1.999999999999ap-2, 0x1.2492492492522p-2, 0x1.c71c71c6ea6c8p-3, 0x1.745d177ac47d7p-3,
                               0x1.3b1395beb5ad0p-3, 0x1.1118cc02cb79ap-3, 0x1.df7bec727b1b0p-4, 0x1.e03770765d720p-4};

// To about 2^-65 of itself.
Pair log_pair(double x) {
  const auto [k, f] = scaled(x);
  const Pair below = sum(2, f);
  const double q = f / below.hi;
  const Pair back = product(q, below.hi);
  const Pair s{q, (((f - back.hi) - back.lo) - q * below.lo) / below.hi};
  const Pair z = product(s, s);
  Pair factor = sum(two_thirds.hi, z.hi * polynomial(logarithm, z.hi));
  factor.lo += two_thirds.lo;
  const Pair more = product(product(s, z), factor);
  const Pair rest = quick_sum(2 * s.hi, more.hi);
  const Pair all = sum(k * ln2_1, rest.hi);
  return quick_sum(all.hi, all.lo + (rest.lo + (2 * s.lo + more.lo) + k * ln2_2));
}

// Where a logarithm is no number or has no end; 0 elsewhere.
double log_of_none(double x) {
  if (x > 0 && x < infinity) return 0;
  return x == 0 ? -infinity : x < 0 ? not_a_number : x;
}

constexpr std::array hyperbolic_sine{0x1.5555555555555p-3,  0x1.1111111111111p-7,  0x1.a01a01a01a001p-13,
                                     0x1.71de3a556f96cp-19, 0x1.ae6456792a77fp-26, 0x1.612467ccb2260p-33,
                                     0x1.ae777c36fd5b6p-41, 0x1.99f0806c2628dp-49};

constexpr std::array hyperbolic_tangent{-0x1.5555555555555p-2,  0x1.11111111110ecp-3,  -0x1.ba1ba1ba15daap-5,
                                        0x1.664f487fed22ap-6,   -0x1.226e34a851d2cp-7, 0x1.d6d39b48449bfp-9,
                                        -0x1.7d9e74586c684p-10, 0x1.350ce30757046p-11, -0x1.efab6555ccc22p-13,
                                        0x1.71eb85bee4b4ap-14,  -0x1.8117b15cbb104p-16};

}  // namespace

double sin(double x) {
  if (std::abs(x) < tiny) return x;
  return std::isfinite(x) ? sine_of(reduce(x)) : not_a_number;
}

double cos(double x) {
  return std::isfinite(x) ? sine_of(reduce(x), 1) : not_a_number;
}

double tan(double x) {
  if (std::abs(x) < tiny) return x;
  if (!std::isfinite(x)) return not_a_number;
  const Angle angle = reduce(x);
  Pair over = small_sine(angle.rest), under = small_cosine(angle.rest);
  if (angle.right_angles % 2 != 0) over = std::exchange(under, {-over.hi, -over.lo});
  const double about = over.hi / under.hi;
  const Pair back = product(about, under.hi);
  return about + (((over.hi - back.hi) - back.lo) + (over.lo - about * under.lo)) / under.hi;
}

double asin(double x) {
  const double size = std::abs(x);
  if (size < tiny || !(size <= 1)) return size <= 1 ? x : not_a_number;
  if (size < 0.5) return x + arc_sine_above(x);
  // as acos, but the root's rounding counts
  const double root = std::sqrt(0.5 * (1 - size));
  const Pair square = product(root, root), most = sum(half_pi.hi, -2 * root);
  const double more = ((0.5 * (1 - size) - square.hi) - square.lo) / (root > 0 ? 2 * root : 1);
  return std::copysign(most.hi + (most.lo + (half_pi.lo - 2 * (more + arc_sine_above(root)))), x);
}

double acos(double x) {
  if (!(std::abs(x) <= 1)) return not_a_number;
  if (x >= 0.5) return steep_arc_cosine(x);
  if (x <= -0.5) return pi.hi - (steep_arc_cosine(-x) - pi.lo);
  return half_pi.hi - (x - (half_pi.lo - arc_sine_above(x)));
}

double atan(double x) {
  return std::isnan(x) ? x : std::copysign(arc(std::abs(x)), x);
}

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return not_a_number;
  const double across = std::abs(y), along = std::abs(x);
  double angle = 0;
  if (std::isinf(across) && std::isinf(along))
    angle = quarter_pi.hi;
  else if (across != 0)
    angle = arc(across / along);
  if (std::signbit(x)) angle = pi.hi - (angle - pi.lo);
  return std::copysign(angle, y);
}

double exp(double x) {
  return std::isnan(x) ? x : power_of_e({x, 0});
}

double exp2(double x) {
  return pow(2, x);
}

double log(double x) {
  if (const double none = log_of_none(x); none != 0) return none;
  const auto [k, f] = scaled(x);
  const double s = f / (2 + f), z = s * s, half = 0.5 * f * f;
  const double more = z * (two_thirds.hi + z * polynomial(logarithm, z));
  return k * ln2_1 - ((half - (s * (half + more) + k * ln2_2)) - f);
}

double log2(double x) {
  if (const double none = log_of_none(x); none != 0) return none;
  return product(log_pair(x), per_ln2).hi;
}

double log10(double x) {
  if (const double none = log_of_none(x); none != 0) return none;
  return product(log_pair(x), per_ln10).hi;
}

double pow(double x, double y) {
  if (y == 0 || x == 1) return 1;
  if (std::isnan(x) || std::isnan(y)) return not_a_number;
  const double size = std::abs(x);
  if (std::isinf(y)) return size == 1 ? 1 : (size > 1) == (y > 0) ? infinity : 0;
  const bool whole = std::floor(y) == y, odd = whole && std::fmod(y, 2) != 0;
  const double sign = std::signbit(x) && odd ? -1 : 1;
  if (size == 0 || std::isinf(size)) return sign * ((size == 0) == (y > 0) ? 0 : infinity);
  if (x < 0 && !whole) return not_a_number;
  if (size == 1) return sign;
  const Pair log_x = log_pair(size);
  const double about = y * log_x.hi;
  if (about > 710) return sign * infinity;
  if (about < -746) return sign * 0;
  const Pair by = product(y, log_x.hi);
  return sign * power_of_e(quick_sum(by.hi, by.lo + y * log_x.lo));
}

double cbrt(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  return std::copysign(power_of_e(product(log_pair(std::abs(x)), third)), x);
}

double sinh(double x) {
  const double size = std::abs(x), z = x * x;
  if (size < tiny || !std::isfinite(x)) return x;
  if (size < 1) return x + x * z * polynomial(hyperbolic_sine, z);
  if (size > 700) return std::copysign(0.5 * exp(0.5 * size) * exp(0.5 * size), x);
  const double e = exp(size);
  return std::copysign(0.5 * e - 0.5 / e, x);
}

double cosh(double x) {
  const double size = std::abs(x);
  if (size > 700) return 0.5 * exp(0.5 * size) * exp(0.5 * size);
  const double e = exp(size);
  return 0.5 * e + 0.5 / e;
}

double tanh(double x) {
  const double size = std::abs(x);
  if (size < tiny || std::isnan(x)) return x;
  if (size < 0.5) return x + x * x * x * polynomial(hyperbolic_tangent, x * x);
  return std::copysign(1 - 2 / (exp(2 * size) + 1), x);
}

double hypot(double x, double y) {
  if (std::isinf(x) || std::isinf(y)) return infinity;
  const double most = std::max(std::abs(x), std::abs(y));
  const double scale = most > 0x1p500 ? 0x1p-600 : most < 0x1p-450 ? 0x1p600 : 1;
  x *= scale, y *= scale;
  return std::sqrt(x * x + y * y) / scale;
}

}  // namespace arkmesh::hal::fixed
