// A link to a scripted original without sockets or wall time: a tick of the original for every few calls of serve().
// What it sends comes late, cut and merged as TCP may; what it is sent comes late, too.
#pragma once

#include <cstdint>
#include <deque>
#include <random>
#include <string>

#include "mark/link.hpp"
#include "tests/support/mark/scripted_originals.hpp"

namespace arkmesh::tests {

struct NetworkOptions {
  unsigned serves_per_tick = 20;  // so that labs have time to do what a tick asks for, as at life speed
  std::uint64_t delay_ticks = 0;  // at most, each way
  bool cuts = false;              // and merges
};

// Owned by the test, and seen by the link that the lab owns.
struct ScriptedNetwork {
  NetworkOptions options;
  ScriptedOriginal* original = nullptr;  // none: nobody is there
  bool was_replaced = false;             // by another one, with another connection
  bool stands = false;                   // the stand-in: it is not served while its original goes on
};

class ScriptedLink final : public mark::Link {
 public:
  explicit ScriptedLink(ScriptedNetwork& network) : network_(network) {}

  void start(Events& events) override { events_ = &events; }
  void open() override {}
  void serve() override {
    if (up_ && (!network_.original || network_.was_replaced)) {
      up_ = false;
      from_original_.clear();
      to_original_.clear();
      ready_.clear();
      events_->gone("it closed its connection");
    }
    if (!network_.original) return;
    if (!up_) {
      up_ = true;
      network_.was_replaced = false;
      events_->came();
    }
    if (++serves_ % network_.options.serves_per_tick == 0) tick();
    if (!network_.stands) deliver();
  }
  // At once, without that others stand still meanwhile: a simulated lab is ahead by what it may, as it is in life.
  hal::TimePoint next_service() const override { return hal::TimePoint{}; }
  bool up() const override { return up_; }
  bool settled() const override { return to_original_.empty(); }
  void send(std::string_view message) override { to_original_.push_back({ticks_ + delay(), std::string(message)}); }
  std::string place() const override { return "127.0.0.1:7001"; }
  std::string error() const override { return up_ ? "" : "it closed its connection"; }

 private:
  struct Segment {
    std::uint64_t due;
    std::string bytes;
  };
  std::uint64_t delay() { return network_.options.delay_ticks ? dice_() % (network_.options.delay_ticks + 1) : 0; }
  void tick() {
    ++ticks_;
    for (; !to_original_.empty() && to_original_.front().due <= ticks_; to_original_.pop_front())
      network_.original->receive(to_original_.front().bytes);
    from_original_.push_back({ticks_ + delay(), network_.original->tick()});
  }
  // In order: a late segment keeps the next ones.
  void deliver() {
    for (; !from_original_.empty() && from_original_.front().due <= ticks_; from_original_.pop_front())
      ready_ += from_original_.front().bytes;
    if (ready_.empty()) return;
    const std::size_t all = ready_.size();
    const std::string segment = ready_.substr(0, network_.options.cuts ? 1 + dice_() % all : all);
    ready_.erase(0, segment.size());
    events_->heard(segment);
  }

  ScriptedNetwork& network_;
  Events* events_ = nullptr;
  bool up_ = false;
  std::uint64_t serves_ = 0, ticks_ = 0;
  std::mt19937 dice_{7};
  std::deque<Segment> from_original_, to_original_;
  std::string ready_;
};

}  // namespace arkmesh::tests
