// A stream that tests hold in their hands: it can be unplugged and made slow, and what an overhead controller at its
// end takes for packets is kept with the time.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/platforms/kilobot/byte_stream.hpp"
#include "hal/platforms/kilobot/packet_port.hpp"
#include "tests/support/kilobot/packet_ear.hpp"

namespace arkmesh::tests {

struct FakeCable {
  struct Heard {
    hal::kilobot::TimePoint at;  // when its last byte was written
    hal::kilobot::Packet packet;
    hal::kilobot::PacketType type() const { return static_cast<hal::kilobot::PacketType>(packet[1]); }
    std::uint8_t message_type() const { return packet[11]; }
  };
  bool plugged = true;
  bool connects = false;  // as TCP does: it can be reset
  hal::kilobot::TimePoint now{};
  std::size_t bytes_a_write = std::numeric_limits<std::size_t>::max();
  std::size_t waiting = 0;
  PacketEar ear;
  std::vector<Heard> heard;

  // What was heard since the last call.
  std::vector<Heard> take() { return std::exchange(heard, {}); }
};

class FakeStream final : public hal::kilobot::ByteStream {
 public:
  explicit FakeStream(std::shared_ptr<FakeCable> cable) : cable_(std::move(cable)) {}
  void open() override {
    open_ = cable_->plugged;
    error_ = open_ ? "" : "there is no cable";
  }
  State check() override {
    if (open_ && !cable_->plugged) {
      open_ = false;
      error_ = "the cable was unplugged";
    }
    return open_ ? State::open : State::closed;
  }
  std::size_t write(std::span<const std::uint8_t> bytes) override {
    if (check() != State::open) return 0;
    const std::size_t taken = std::min(bytes.size(), cable_->bytes_a_write);
    for (const auto& packet : cable_->ear.hear(bytes.first(taken))) cable_->heard.push_back({cable_->now, packet});
    return taken;
  }
  std::size_t waiting_bytes() override { return cable_->waiting; }
  bool reset() override {
    if (cable_->connects) open_ = false;
    return cable_->connects;
  }
  const std::string& error() const override { return error_; }

 private:
  std::shared_ptr<FakeCable> cable_;  // shared with the test, which outlives no stream
  bool open_ = false;
  std::string error_;
};

}  // namespace arkmesh::tests
