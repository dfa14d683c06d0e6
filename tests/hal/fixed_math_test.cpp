// Functions that give the same bits everywhere: those bits, and how near they are.
#include "hal/fixed_math.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "hal/random.hpp"

namespace fixed = arkmesh::hal::fixed;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

struct Golden {
  const char* what;
  double got, bits;
};

// Distance from what 64 bits of mantissa say, in units of the last place.
double ulps_off(double got, long double wanted) {
  const double rounded = std::abs(static_cast<double>(wanted));
  return static_cast<double>(std::abs(got - wanted)) / (std::nextafter(rounded, infinite) - rounded);
}

// The worst of many numbers between `from` and `to`.
template <class Function, class Wanted>
double worst(Function function, Wanted wanted, double from, double to) {
  arkmesh::hal::RandomStream stream(1, "test/fixed_math");
  double out = 0;
  for (int i = 0; i < 2000; ++i) {
    const double x = stream.uniform(from, to);
    out = std::max(out, ulps_off(function(x), wanted(static_cast<long double>(x))));
  }
  return out;
}

}  // namespace

TEST_CASE("functions of mathematics give these bits") {
  const std::vector<Golden> all{{"sin(0.7)", fixed::sin(0.7), 0x1.49d6e694619b8p-1},
                                {"sin(100.25)", fixed::sin(100.25), -0x1.1bf00980dc35cp-2},
                                {"sin(1e22)", fixed::sin(1e22), -0x1.b453ab76bf397p-1},
                                {"sin(0x1.6ac5b262ca1ffp+849)", fixed::sin(0x1.6ac5b262ca1ffp+849), 0x1p+0},
                                {"cos(2.5)", fixed::cos(2.5), -0x1.9a2f7ef858b7dp-1},
                                {"cos(-3e8)", fixed::cos(-3e8), 0x1.cbe31d447d1e2p-1},
                                {"tan(1.3)", fixed::tan(1.3), 0x1.cd11b1696e97ep+1},
                                {"tan(-1234.5)", fixed::tan(-1234.5), 0x1.2cf7f008a6a32p-3},
                                {"asin(0.3)", fixed::asin(0.3), 0x1.380159e14f6fep-2},
                                {"asin(-0.9)", fixed::asin(-0.9), -0x1.1ea93705fa172p+0},
                                {"acos(0.2)", fixed::acos(0.2), 0x1.5e9383efad0d1p+0},
                                {"acos(-0.7)", fixed::acos(-0.7), 0x1.2c501446cd5f2p+1},
                                {"atan(0.35)", fixed::atan(0.35), 0x1.58c148aa9c5d6p-2},
                                {"atan(-3.0)", fixed::atan(-3.0), -0x1.3fc176b7a856p+0},
                                {"atan2(-1.5,-2.25)", fixed::atan2(-1.5, -2.25), -0x1.46dc09ec29433p+1},
                                {"atan2(3e-300,7.0)", fixed::atan2(3e-300, 7.0), 0x1.25e645df9f528p-998},
                                {"sinh(0.4)", fixed::sinh(0.4), 0x1.a49c41f850ed2p-2},
                                {"sinh(-9.5)", fixed::sinh(-9.5), -0x1.a17dd064d36acp+12},
                                {"cosh(1.75)", fixed::cosh(1.75), 0x1.7b6a85c4bbdc3p+1},
                                {"tanh(0.25)", fixed::tanh(0.25), 0x1.f597ea69a1c86p-3},
                                {"tanh(2.0)", fixed::tanh(2.0), 0x1.ed9505e1bc3d4p-1},
                                {"exp(1.0)", fixed::exp(1.0), 0x1.5bf0a8b145769p+1},
                                {"exp(-745.0)", fixed::exp(-745.0), 0x0.0000000000001p-1022},
                                {"exp(700.5)", fixed::exp(700.5), 0x1.8625c7d4f56c2p+1010},
                                {"exp2(0.3)", fixed::exp2(0.3), 0x1.3b2c47bff8329p+0},
                                {"log(3.0)", fixed::log(3.0), 0x1.193ea7aad030ap+0},
                                {"log(1e-310)", fixed::log(1e-310), -0x1.64e69394d9508p+9},
                                {"log2(10.0)", fixed::log2(10.0), 0x1.a934f0979a371p+1},
                                {"log10(7.0)", fixed::log10(7.0), 0x1.b0b0b0b78cc3fp-1},
                                {"pow(1.0001,65536.0)", fixed::pow(1.0001, 65536.0), 0x1.5ec49e8595e59p+9},
                                {"pow(2.5,-3.75)", fixed::pow(2.5, -3.75), 0x1.07b3f176b0a79p-5},
                                {"pow(10.0,-5.0)", fixed::pow(10.0, -5.0), 0x1.4f8b588e368fp-17},
                                {"cbrt(-2.0)", fixed::cbrt(-2.0), -0x1.428a2f98d728bp+0},
                                {"hypot(0.3,0.4)", fixed::hypot(0.3, 0.4), 0x1p-1},
                                {"hypot(1e200,3e200)", fixed::hypot(1e200, 3e200), 0x1.08669e596b4f8p+666}};
  for (const Golden& one : all) {
    CAPTURE(one.what);
    CHECK(one.got == one.bits);
  }
}

TEST_CASE("functions of mathematics are within two units in the last place") {
  struct Row {
    const char* name;
    double (*function)(double);
    long double (*wanted)(long double);
    double from, to;
  };
  const std::vector<Row> rows{{"sin", fixed::sin, std::sin, -10, 10},    {"sin", fixed::sin, std::sin, -1e9, 1e9},
                              {"cos", fixed::cos, std::cos, -10, 10},    {"tan", fixed::tan, std::tan, -10, 10},
                              {"asin", fixed::asin, std::asin, -1, 1},   {"acos", fixed::acos, std::acos, -1, 1},
                              {"atan", fixed::atan, std::atan, -5, 5},   {"sinh", fixed::sinh, std::sinh, -5, 5},
                              {"cosh", fixed::cosh, std::cosh, -5, 5},   {"tanh", fixed::tanh, std::tanh, -2, 2},
                              {"exp", fixed::exp, std::exp, -700, 700},  {"exp2", fixed::exp2, std::exp2, -20, 20},
                              {"log", fixed::log, std::log, 0, 3},       {"log2", fixed::log2, std::log2, 0, 3},
                              {"log10", fixed::log10, std::log10, 0, 3}, {"cbrt", fixed::cbrt, std::cbrt, -9, 9}};
  for (const Row& row : rows) {
    CAPTURE(row.name);
    CHECK(worst(row.function, row.wanted, row.from, row.to) < 2);
  }
  CHECK(worst([](double x) { return fixed::pow(x, 1.7); },
              [](long double x) { return std::pow(x, static_cast<long double>(1.7)); }, 0, 50) < 1);
  CHECK(worst([](double x) { return fixed::atan2(x, -0.25); }, [](long double x) { return std::atan2(x, -0.25L); }, -2,
              2) < 2);
  CHECK(worst([](double x) { return fixed::hypot(x, 3.5); }, [](long double x) { return std::hypot(x, 3.5L); }, -9, 9) <
        2);
}

TEST_CASE("functions of mathematics at their ends") {
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const double x :
       {fixed::sin(infinite), fixed::cos(-infinite), fixed::asin(1.5), fixed::acos(-2), fixed::log(-1),
        fixed::pow(-2, 0.5), fixed::sin(none), fixed::exp(none), fixed::pow(none, 2), fixed::atan2(1, none)})
    CHECK(std::isnan(x));
  CHECK(fixed::exp(1000) == infinite);
  CHECK(fixed::exp(-1000) == 0);
  CHECK(fixed::log(0) == -infinite);
  CHECK(fixed::pow(-2, 3) == -8);
  CHECK(fixed::pow(-1, 1e308) == 1);
  CHECK(fixed::pow(0, -1) == infinite);
  CHECK(fixed::pow(10, 22) == 1e22);
  CHECK(fixed::log10(1000) == 3);
  CHECK(fixed::cbrt(-27) == -3);
  CHECK(std::signbit(fixed::sin(-0.0)));
  CHECK(fixed::atan2(-0.0, -1) == -fixed::acos(-1));
  CHECK(fixed::hypot(-infinite, none) == infinite);
}
