// Structure of arrays in single precision; a 10 cm grid by counting sort in each step; each robot sends twice a second.
#include "tests/bench/bare_swarm.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace arkmesh::bench {
namespace {

constexpr float step_s = 1.0f / 32, speed = 0.01f, turn = 0.7854f, range_m = 0.1f;

// As long as a Kilobot's.
struct Message {
  std::array<std::uint8_t, 12> bytes{};
};

}  // namespace

struct BareSwarm::State {
  int n, columns;
  float half;
  std::vector<float> x, y, c, s, v, turn_c, turn_s, box_distance;
  std::vector<int> until, cell, member, first;
  std::vector<Message> sent, box;
  std::uint32_t random = 12345;
  std::uint64_t received = 0;
  int number = 0;
  std::uint32_t next() {
    random ^= random << 13;
    random ^= random >> 17;
    return random ^= random << 5;
  }
  float unit() { return static_cast<float>(next() >> 8) * 0x1p-24f; }
};

BareSwarm::BareSwarm(int robots, float side_m) : state_(std::make_unique<State>()) {
  State& w = *state_;
  w.n = robots;
  w.half = side_m / 2;
  w.columns = std::max(1, static_cast<int>(std::ceil(side_m / range_m)));
  const auto n = static_cast<std::size_t>(robots);
  for (auto* v : {&w.x, &w.y, &w.c, &w.s, &w.v, &w.turn_c, &w.turn_s, &w.box_distance}) v->assign(n, 0);
  for (auto* v : {&w.until, &w.cell, &w.member}) v->assign(n, 0);
  w.sent.resize(n);
  w.box.resize(n);
  for (std::size_t i = 0; i < n; ++i) w.sent[i].bytes[0] = static_cast<std::uint8_t>(i);
  w.first.assign(static_cast<std::size_t>(w.columns * w.columns) + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    w.x[i] = (w.unit() - 0.5f) * side_m;
    w.y[i] = (w.unit() - 0.5f) * side_m;
    const float heading = 6.2831853f * w.unit();
    w.c[i] = std::cos(heading);
    w.s[i] = std::sin(heading);
  }
}

BareSwarm::~BareSwarm() = default;

void BareSwarm::step() {
  State& w = *state_;
  ++w.number;
  const auto n = static_cast<std::size_t>(w.n);
  for (std::size_t i = 0; i < n; ++i) {
    if (w.until[i] > w.number) continue;
    w.until[i] = w.number + 16 + static_cast<int>(w.next() & 15);
    const std::uint32_t kind = w.next() & 3;
    const float angle = kind == 0 ? turn * step_s : kind == 1 ? -turn * step_s : 0;
    w.v[i] = kind < 2 ? 0 : speed * step_s;
    w.turn_c[i] = std::cos(angle);
    w.turn_s[i] = std::sin(angle);
  }
  for (std::size_t i = 0; i < n; ++i) {
    w.x[i] = std::clamp(w.x[i] + w.c[i] * w.v[i], -w.half, w.half);
    w.y[i] = std::clamp(w.y[i] + w.s[i] * w.v[i], -w.half, w.half);
    const float c = w.c[i];
    w.c[i] = c * w.turn_c[i] - w.s[i] * w.turn_s[i];
    w.s[i] = c * w.turn_s[i] + w.s[i] * w.turn_c[i];
  }
  std::fill(w.first.begin(), w.first.end(), 0);
  const auto place = [&w](float at) { return std::min(w.columns - 1, static_cast<int>((at + w.half) / range_m)); };
  for (std::size_t i = 0; i < n; ++i)
    ++w.first[static_cast<std::size_t>(w.cell[i] = place(w.y[i]) * w.columns + place(w.x[i]))];
  int total = 0;
  for (int& f : w.first) f = total += f;
  for (std::size_t i = n; i-- > 0;)
    w.member[static_cast<std::size_t>(--w.first[static_cast<std::size_t>(w.cell[i])])] = static_cast<int>(i);
  // every 16th robot sends
  for (std::size_t i = static_cast<std::size_t>(w.number & 15); i < n; i += 16) {
    const int column = w.cell[i] % w.columns, row = w.cell[i] / w.columns;
    for (int r = std::max(0, row - 1); r <= std::min(w.columns - 1, row + 1); ++r) {
      const auto from = static_cast<std::size_t>(r * w.columns + std::max(0, column - 1)),
                 to = static_cast<std::size_t>(r * w.columns + std::min(w.columns - 1, column + 1));
      for (int k = w.first[from]; k < w.first[to + 1]; ++k) {
        const auto j = static_cast<std::size_t>(w.member[static_cast<std::size_t>(k)]);
        const float dx = w.x[j] - w.x[i], dy = w.y[j] - w.y[i], d2 = dx * dx + dy * dy;
        if (d2 > range_m * range_m || j == i || w.unit() > 0.8f) continue;
        w.box[j] = w.sent[i];
        w.box_distance[j] = std::sqrt(d2);
        ++w.received;
      }
    }
  }
}

std::uint64_t BareSwarm::messages() const {
  return state_->received;
}

}  // namespace arkmesh::bench
