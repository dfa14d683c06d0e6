// How many bytes may be under way to a peer that has not acknowledged them. Little enough that what waits stays where a
// newer value can replace it, and that what is under way arrives soon. Pure; the caller owns time.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace arkmesh::gateway {

struct FlowLimits {
  std::size_t bytes = 256 << 10;             // never more under way
  std::chrono::microseconds delay{100'000};  // nor more than arrives in so much more than the path itself takes
};

class FlowWindow {
 public:
  using Time = std::chrono::steady_clock::time_point;
  // Where it begins; on a path of 100 ms it has grown to 256 KiB after half a second.
  static constexpr std::size_t first_bytes = 16 << 10, least_bytes = 1 << 10;

  explicit FlowWindow(FlowLimits limits) : limits_(limits), window_(std::min(first_bytes, limits.bytes)) {}

  // What may be sent now: next to nothing while the timed byte is late, since the path has become slower by more than
  // is known. Not 0 when nothing is under way.
  std::size_t room(Time now) const {
    const std::size_t window = late(now) ? std::min(window_, least_bytes) : window_;
    return window > under_way() ? window - under_way() : 0;
  }
  void sent(std::size_t bytes, Time now);
  // `total`: bytes since the beginning. False when so much was never sent, or it is less than before.
  bool acknowledged(std::uint64_t total, Time now);
  // Something small went there and back in so long: the path is not slower than that.
  void path_takes(std::chrono::duration<double> there_and_back) { path_ = std::clamp(there_and_back, {}, path_); }
  // The peer may wait so long with an acknowledgement: nobody is late for that.
  void peer_waits(std::chrono::milliseconds time) { peer_waits_ = time; }
  std::size_t under_way() const { return static_cast<std::size_t>(sent_ - acknowledged_); }
  // Since when the peer has acknowledged nothing although something is under way.
  std::optional<Time> waits_since() const { return under_way() > 0 ? std::optional(progress_) : std::nullopt; }

 private:
  // Of what is under way one byte is timed.
  struct Sample {
    std::uint64_t total;
    std::uint64_t acknowledged;  // when it was sent
    Time sent;
    bool filled;  // the window was in the way
  };
  std::chrono::duration<double> aim() const { return path_ + limits_.delay + peer_waits_; }
  bool late(Time now) const { return sample_ && now - sample_->sent > 2 * aim(); }
  void adapt(const Sample& sample, std::chrono::duration<double> delay);

  FlowLimits limits_;
  std::chrono::milliseconds peer_waits_{0};
  std::size_t window_;
  std::uint64_t sent_ = 0, acknowledged_ = 0;
  Time progress_{};
  std::optional<Sample> sample_;
  // The least delay seen: the path's own, but for queues. A path that seems slower than this at first is not believed.
  std::chrono::duration<double> path_{0.3};
};

}  // namespace arkmesh::gateway
