// Pictures as a camera on the network serves them: motion JPEG over HTTP, which browsers and OpenCV open by URL. Takes
// pictures that are encoded already. Works while the event loop runs; nothing here blocks, and there is no thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hal/counters.hpp"
#include "hal/event_loop.hpp"

namespace arkmesh::hal {

// GET /NAME streams, GET /NAME.jpg is one picture by itself (the next, when the last is older than a second), GET / a
// page with all. What clients can make it hold is bounded: in number, in the length of their requests, in one picture
// each; who sends no request or takes nothing for long is sent away.
class MjpegServer {
 public:
  static constexpr std::size_t max_clients = 32;

  // Listens on `address` (127.0.0.1 unless told otherwise) and `port`; 0 takes any free one. `loop` outlives the
  // server. Throws std::runtime_error with one sentence when the port is taken or not allowed.
  MjpegServer(EventLoop& loop, const std::string& address, std::uint16_t port);
  ~MjpegServer();
  MjpegServer(const MjpegServer&) = delete;
  MjpegServer& operator=(const MjpegServer&) = delete;
  std::uint16_t port() const;
  // The stream is there, though nothing was shown yet: clients may come and wait for its pictures. Only so can
  // watchers() decide whether pictures are encoded at all.
  void announce(const std::string& stream);
  // The stream's newest picture. Streams are paths: "camera0" is http://ADDRESS:PORT/camera0; "/" lists them.
  // A client that is still busy with an earlier picture misses this one, which is counted (`mjpeg.skipped`).
  void show(const std::string& stream, std::span<const std::byte> jpeg);
  // The stream is no more: its clients are sent away, and whoever asks for it is told that there is none, until the
  // next show().
  void close(const std::string& stream);
  // How many clients watch that stream now, or wait for one picture of it: nobody needs pictures encoded that nobody
  // watches.
  std::size_t watchers(const std::string& stream) const;
  const Counters& counters() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arkmesh::hal
