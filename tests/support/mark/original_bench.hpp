// An original over a link of which the test is the other end, on wall time that the test lets pass.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mark/original.hpp"

namespace arkmesh::tests {

using namespace std::chrono_literals;

class BenchWall final : public hal::WallTime {
 public:
  hal::TimePoint now() override { return now_; }
  void wait_until(hal::TimePoint then) override { now_ = then; }

 private:
  hal::TimePoint now_{1h};
};

struct BenchLink final : mark::Link {
  void start(Events& given) override { events = &given; }
  void open() override { is_open = true; }
  void serve() override {}
  hal::TimePoint next_service() const override { return hal::TimePoint::max(); }
  bool up() const override { return is_up; }
  bool settled() const override { return has_settled; }
  void send(std::string_view message) override { sent.emplace_back(message); }
  std::string place() const override { return "127.0.0.1:7001"; }
  std::string error() const override { return {}; }

  Events* events = nullptr;
  bool is_open = false, is_up = false, has_settled = true;
  std::vector<std::string> sent;
};

struct OriginalBench {
  // Two sites.
  OriginalBench(const mark::Settings& settings, mark::Role role, mark::Conversation& conversation)
      : original(settings, role, {.role = role, .flavour = settings.flavour, .sites = 2}, conversation, make(),
                 mark::Original::Away::stands_still, counters, wall) {
    original.open();
    link->is_up = true;
    link->events->came();
  }
  std::unique_ptr<mark::Link> make() {
    auto made = std::make_unique<BenchLink>();
    link = made.get();
    return made;
  }
  // It says something, and is served; what it is told.
  std::vector<std::string> hear(std::string_view bytes) {
    link->sent.clear();
    link->events->heard(bytes);
    original.serve();
    return link->sent;
  }
  // Serves each 10 ms for so long; what was sent meanwhile.
  std::vector<std::string> pass(std::chrono::milliseconds time) {
    link->sent.clear();
    for (const auto until = wall.now() + time; wall.now() < until; wall.wait_until(wall.now() + 10ms)) original.serve();
    return link->sent;
  }

  BenchWall wall;
  hal::Counters counters;
  BenchLink* link = nullptr;
  mark::Original original;
};

}  // namespace arkmesh::tests
