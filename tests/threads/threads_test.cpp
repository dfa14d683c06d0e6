// The two threads there are, a camera's and a serial line's, beside those who ask them: built with the thread
// sanitizer, which ends the program with an error at the first race.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "emulator/serial_reader.hpp"
#include "hal/listening_socket.hpp"
#include "hal/mjpeg_server.hpp"
#include "tracker/live_camera.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

namespace {

// Calls `each` until it is true; false after 30 s.
bool soon(const std::function<bool()>& each) {
  const auto end = std::chrono::steady_clock::now() + 30s;
  while (!each()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

}  // namespace

TEST_CASE("threads: a camera comes, goes and comes back") {
  // Pictures, troubles and counters are asked for by one thread while another reads the stream; the feed ends while
  // pictures still come.
  hal::MjpegServer server("127.0.0.1", 0);
  std::vector<std::uint8_t> jpeg;
  std::uint8_t grey = 0;
  const auto show = [&] {
    cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(++grey)), jpeg);
    server.show("camera0", std::as_bytes(std::span(jpeg)));
    server.serve();
  };
  server.announce("camera0");
  {
    const auto feed = tracker::open_camera(fmt::format("http://127.0.0.1:{}/camera0", server.port()));
    for (int times = 0; times < 2; ++times) {
      int pictures = 0;
      CHECK(soon([&] {
        show();
        pictures += !feed->newest().empty();
        return pictures >= 20 && feed->trouble().empty();
      }));
      server.close("camera0");
      CHECK(soon([&] {
        server.serve();
        static_cast<void>(feed->newest());
        return !feed->trouble().empty();
      }));
      CHECK(feed->counters()["camera.gone"] == static_cast<std::uint64_t>(times) + 1);
    }
    CHECK(soon([&] {
      show();
      return !feed->newest().empty();
    }));
  }
  show();
}

TEST_CASE("threads: a serial line that is written to, unplugged and plugged in") {
  // Every byte that a host writes is taken once and in order, while the line's end is taken away and put back.
  emulator::SerialReader line("127.0.0.1", 0, "");
  std::uint8_t next = 0, expected = 0;
  for (int times = 0; times < 3; ++times) {
    const int host = ::open(line.terminal().c_str(), O_WRONLY | O_NOCTTY);
    REQUIRE(host >= 0);
    std::size_t written = 0, taken = 0;
    CHECK(soon([&] {
      if (written < 2000) {
        const std::uint8_t bytes[] = {next++, next++};
        REQUIRE(::write(host, bytes, 2) == 2);
        written += 2;
      }
      emulator::SerialReader::TimePoint until;
      for (const auto& chunk : line.take(until))
        for (const std::uint8_t byte : chunk.bytes) {
          REQUIRE(byte == expected++);
          ++taken;
        }
      return taken == 2000;
    }));
    ::close(host);
    line.set_plugged(false);
    CHECK(line.terminal().empty());
    line.set_plugged(true);
  }
}
