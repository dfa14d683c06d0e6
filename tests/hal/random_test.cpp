// The named random streams.
#include "hal/random.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <set>

using namespace arkmesh::hal;

TEST_CASE("a stream is a function of seed, name, index and count") {
  // Equal ones are equal; one difference in any of them gives another stream. The pinned values keep runs comparable
  // between versions: whoever changes them changes every result.
  RandomStream a(1, "shark/sites"), b(1, "shark/sites");
  for (int i = 0; i < 100; ++i) CHECK(a.next() == b.next());
  CHECK(a.count() == 100);
  std::set<std::uint64_t> firsts;
  for (std::uint64_t seed : {1, 2})
    for (const char* name : {"shark/sites", "shark/site", "sshark/ites", "roark/sites"})
      for (std::uint64_t index : {0, 1, 2}) firsts.insert(RandomStream(seed, name, index).next());
  CHECK(firsts.size() == 24);
  RandomStream pinned(1, "shark/sites");
  CHECK(pinned.next() == 51142058593343471ULL);
  CHECK(pinned.next() == 18279344600000140945ULL);
}

TEST_CASE("uniform, below and normal have the moments they should") {
  // 100000 draws; the bounds are five standard errors wide.
  RandomStream stream(3, "test");
  const int n = 100'000;
  double sum = 0, squares = 0, uniform = 0;
  std::array<int, 10> bins{};
  for (int i = 0; i < n; ++i) {
    const double x = stream.normal();
    sum += x, squares += x * x;
    const double u = stream.uniform(-1, 1);
    CHECK_UNARY(u >= -1 && u < 1);
    uniform += u;
    ++bins.at(stream.below(10));
  }
  CHECK(std::abs(sum / n) < 5 / std::sqrt(n));
  CHECK(std::abs(squares / n - 1) < 5 * std::sqrt(2.0 / n));
  CHECK(std::abs(uniform / n) < 5 * std::sqrt(1.0 / 3 / n));
  for (int bin : bins) CHECK(std::abs(bin - n / 10) < 5 * std::sqrt(n * 0.09));
}
