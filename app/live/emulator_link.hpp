// The way to an emulated testbed that is a process of its own: lines of text to its control port, each answered with
// one.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hal/event_loop.hpp"

namespace arkmesh::app {

class EmulatorLink {
 public:
  using Heard = std::function<void(const std::string& said)>;

  // The loop outlives it.
  EmulatorLink(hal::EventLoop& loop, const boost::asio::ip::tcp::endpoint& to) : loop_(loop), to_(to) {}
  ~EmulatorLink();
  EmulatorLink(const EmulatorLink&) = delete;
  EmulatorLink& operator=(const EmulatorLink&) = delete;

  // Says a line without its end. `heard` is called within 2 s, from the loop or at once, with the answer or with
  // "error: " and a sentence; never once the link is gone.
  void ask(std::string_view line, Heard heard);

 private:
  struct Question;
  hal::EventLoop& loop_;
  boost::asio::ip::tcp::endpoint to_;
  std::vector<std::weak_ptr<Question>> waiting_;
};

}  // namespace arkmesh::app
