// One peer over any transport. The gateway talks to links only through this file.
// Threading: everything happens on the thread that runs the gateway's loop.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "gateway/session/clock_estimate.hpp"
#include "hal/counters.hpp"

namespace arkmesh::gateway {

enum class Delivery {
  latest,   // a newer message on the same channel replaces a waiting older one
  ordered,  // all of them, once and in order, as long as the outbox has room; then the oldest is dropped
};

// What happens to one exported channel on its way to one peer. A link without an outbox need not heed the limits.
struct Rule {
  static constexpr double unlimited = std::numeric_limits<double>::infinity();

  std::string channel;  // what the peer calls it; never contains '/'
  Delivery delivery = Delivery::latest;
  double rate_hz = unlimited, bytes_per_s = unlimited;  // what is more waits
};

struct LinkStats {
  bool up = false;
  std::string why;                                  // reason of the last change, in words
  std::uint64_t peer_boot_id = 0;                   // 0 until the peer was met
  std::string peer_version;                         // of its arkmesh; empty until then
  std::optional<ClockEstimate::Clock> clock;        // the peer's, where a link knows it
  std::int64_t peer_wall_offset_us = 0;             // what its wall clock shows more than ours, as uncertain as that
  std::uint64_t sent_messages = 0, sent_bytes = 0;  // payload bytes
  std::uint64_t received_messages = 0, received_bytes = 0;
  hal::Counters counters;  // everything dropped, replaced, refused or failed, by reason
};

class Link {
 public:
  struct Events {
    std::function<void(std::string_view channel, std::span<const std::byte> bytes)> arrived;
    std::function<void(bool up, std::string_view why)> changed;
  };
  virtual ~Link() = default;
  // Name of the peer lab.
  virtual const std::string& peer() const = 0;
  // Begins to connect (or to accept), and not before. Events may come from then on until stop() returns.
  virtual void start(Events events) = 0;
  // Takes a copy for sending; never blocks. While the link is down, or not started yet, `latest` keeps the newest,
  // `ordered` the newest that fit.
  virtual void offer(const Rule& rule, std::string_view channel, std::span<const std::byte> bytes) = 0;
  // Rules have changed: what waits on other channels than these is dropped, and counted.
  using Passes = std::function<bool(std::string_view channel)>;
  virtual void keep_only(const Passes& passes) = 0;
  virtual LinkStats stats() const = 0;
  // Closes for good; returns at once; no event comes afterwards.
  virtual void stop() = 0;
};

}  // namespace arkmesh::gateway
