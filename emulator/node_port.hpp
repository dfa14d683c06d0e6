// The port at which hosts reach an emulator's nodes: what one says goes to the nodes, what nodes say to all, as
// asebaswitch does. Nothing here blocks; who does not take what nodes say is sent away.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "hal/counters.hpp"
#include "hal/event_loop.hpp"
#include "hal/platforms/aseba/protocol.hpp"

namespace arkmesh::emulator {

class NodePort {
 public:
  // Works while `loop` runs, which outlives it. At most 8 hosts. Throws std::runtime_error with one sentence.
  NodePort(hal::EventLoop& loop, const std::string& address, std::uint16_t port,
           std::function<void(const hal::aseba::Message&)> take);
  ~NodePort();
  NodePort(const NodePort&) = delete;
  NodePort& operator=(const NodePort&) = delete;

  void say(std::span<const std::uint8_t> bytes);
  // Sends all hosts away; they may come again.
  void cut();
  std::uint16_t port() const;
  // `nodes.damaged_bytes` of hosts; `nodes.refused.slow`, `.too_many`: hosts that were sent away.
  const hal::Counters& counters() const;

 private:
  struct State;
  std::shared_ptr<State> state_;  // the loop's pending calls hold it weakly
};

}  // namespace arkmesh::emulator
