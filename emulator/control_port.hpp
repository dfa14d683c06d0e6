// Lines of text over TCP, each answered with one. Nothing here blocks; what clients can make it hold is bounded: in
// number and in the length of a line, and who takes no answer is not read from. Who says a line of HTTP is told so and
// sent away, and nothing behind that line is a command: browsers let any web page post text to a port of this machine.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "hal/counters.hpp"
#include "hal/event_loop.hpp"

namespace arkmesh::emulator {

class ControlPort {
 public:
  // Works while `loop` runs, which outlives it. `what` says in an error what the port is for. Throws std::runtime_error
  // with one sentence.
  ControlPort(hal::EventLoop& loop, const std::string& address, std::uint16_t port, const std::string& what,
              std::function<std::string(std::string_view line)> answer);
  ~ControlPort();
  ControlPort(const ControlPort&) = delete;
  ControlPort& operator=(const ControlPort&) = delete;
  std::uint16_t port() const;
  // `control.refused.http`: connections that spoke HTTP; `control.refused.too_many`: beyond 8 at once.
  const hal::Counters& counters() const;

 private:
  struct State;
  std::shared_ptr<State> state_;  // the loop's pending calls hold it weakly
};

}  // namespace arkmesh::emulator
