// TCP gateways of one test in one loop, with short time limits so that tests are quick.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "gateway/links/connections.hpp"

namespace arkmesh::tests {

// A fifth of the real limits, and below; but a busy machine may keep the test itself away for a second, and no peer is
// gone for that.
inline gateway::SessionTimes short_times() {
  using std::chrono::milliseconds;
  gateway::SessionTimes times;
  times.heartbeat = milliseconds(100);
  times.silence = milliseconds(2000);
  times.stall = milliseconds(5000);
  times.hello = milliseconds(600);
  times.goodbye = milliseconds(300);
  return times;
}

inline gateway::TcpSettings tcp_settings(const std::string& lab, std::uint64_t boot_id) {
  gateway::TcpSettings settings;
  settings.lab = lab;
  settings.experiment = "dhtf";
  settings.boot_id = boot_id;
  for (const char* channel : {"world", "status", "events"}) settings.exports.push_back(gateway::exported(channel));
  settings.times = short_times();
  settings.longest_retry = std::chrono::milliseconds(200);
  return settings;
}

// Lets the loop turn until the condition holds; false when the deadline passed first.
template <class Condition>
bool run_until(boost::asio::io_context& io, Condition condition,
               std::chrono::seconds deadline = std::chrono::seconds(300)) {
  const auto end = std::chrono::steady_clock::now() + deadline;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    io.restart();
    io.run_one_for(std::chrono::milliseconds(5));
    io.poll();
  }
  return true;
}

}  // namespace arkmesh::tests
