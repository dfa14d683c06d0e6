// The threads there are, a camera's, a serial line's and a host lookup's, beside those who ask them: built with the
// thread sanitizer, which ends the program with an error at the first race.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "emulator/serial_reader.hpp"
#include "gateway/links/host_lookup.hpp"
#include "hal/http/mjpeg_server.hpp"
#include "testbed/record_writer.hpp"
#include "tracker/camera/live_camera.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

namespace {

// Calls `each` until it is true; false after five minutes.
bool soon(const std::function<bool()>& each) {
  const auto end = std::chrono::steady_clock::now() + 300s;
  while (!each()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

}  // namespace

TEST_CASE("threads: a record is written beside the lab") {
  // Lines and pictures come while others are written, totals and troubles are asked meanwhile, and the end waits until
  // all of it lies in the folder. Pictures that are still looked at are only read.
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("arkmesh-threads-{}", ::getpid());
  const cv::Mat picture(60, 80, CV_8UC3, cv::Scalar(10, 20, 30));
  {
    testbed::RecordWriter writer({.folder = folder, .patient = true, .hold_bytes = 50'000});
    writer.line("serial.txt", "before");
    writer.begin();
    for (int i = 0; i < 200; ++i) {
      writer.line("serial.txt", std::to_string(i));
      CHECK(writer.picture(fmt::format("camera0/{}.png", i), picture, {}));
      CHECK(cv::sum(picture)[0] == 48'000);
      CHECK(writer.written().pictures <= static_cast<std::uint64_t>(i) + 1);
      CHECK(writer.error().empty());
    }
    writer.finish();
    CHECK(writer.written().pictures == 200);
    CHECK(writer.counters().all().empty());
  }
  std::size_t files = 0;
  for (const auto& each : std::filesystem::directory_iterator(folder / "camera0")) files += each.file_size() > 0;
  CHECK(files == 200);
  std::ifstream in(folder / "serial.txt");
  std::size_t lines = 0;
  for (std::string line; std::getline(in, line);) ++lines;
  CHECK(lines == 201);
  std::filesystem::remove_all(folder);
}

TEST_CASE("threads: hosts are looked up, and lookups are given up") {
  // Each lookup tells once, also when it is given up while its thread is at work or has just found something, and when
  // its loop is gone before its thread.
  for (int i = 0; i < 40; ++i) {
    boost::asio::io_context loop;
    int told = 0;
    std::string error;
    std::vector<boost::asio::ip::tcp::endpoint> addresses;
    gateway::HostLookup lookup(loop.get_executor(), {"localhost", 7444}, [&](const std::string& why, auto found) {
      ++told;
      error = why;
      addresses = std::move(found);
    });
    if (i % 4 == 3) continue;
    if (i % 2 == 1) lookup.cancel();
    CHECK(soon([&] {
      loop.restart();
      loop.poll();
      return told > 0;
    }));
    if (i % 2 == 0) {
      CHECK(error == "");
      REQUIRE(!addresses.empty());
      CHECK(addresses.front().port() == 7444);
    }
    loop.poll();
    CHECK(told == 1);
  }
}

TEST_CASE("threads: a camera comes, goes and comes back") {
  // Pictures, troubles and counters are asked for by one thread while another reads the stream; the feed ends while
  // pictures still come.
  hal::EventLoop loop;
  hal::MjpegServer server(loop, "127.0.0.1", 0);
  std::vector<std::uint8_t> jpeg;
  std::uint8_t grey = 0;
  const auto show = [&] {
    cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(++grey)), jpeg);
    server.show("camera0", std::as_bytes(std::span(jpeg)));
    loop.poll();
  };
  server.announce("camera0");
  {
    const auto feed = tracker::open_camera({.source = fmt::format("http://127.0.0.1:{}/camera0", server.port())});
    for (int times = 0; times < 2; ++times) {
      int pictures = 0;
      CHECK(soon([&] {
        show();
        pictures += !feed->newest().empty();
        return pictures >= 20 && feed->error().empty();
      }));
      server.close("camera0");
      CHECK(soon([&] {
        loop.poll();
        static_cast<void>(feed->newest());
        return !feed->error().empty();
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
  hal::EventLoop loop;
  std::uint8_t next = 0, expected = 0;
  std::size_t taken = 0;
  std::unique_ptr<emulator::SerialReader> line;
  const auto take = [&](const emulator::SerialReader::Chunk& chunk) {
    for (const std::uint8_t byte : chunk.bytes) REQUIRE(byte == expected++);
    taken += chunk.bytes.size();
    line->done(chunk.bytes.size());
  };
  line = std::make_unique<emulator::SerialReader>(loop, "127.0.0.1", 0, "", take);
  for (int times = 0; times < 3; ++times) {
    const int host = ::open(line->terminal().c_str(), O_WRONLY | O_NOCTTY | O_NONBLOCK);
    REQUIRE(host >= 0);
    std::size_t written = 0;
    taken = 0;
    // more than the reader holds at once; a full line takes one byte of two, or none for now
    CHECK(soon([&] {
      if (written < 6000) {
        const std::uint8_t bytes[] = {next, static_cast<std::uint8_t>(next + 1)};
        const ssize_t took = ::write(host, bytes, 2);
        REQUIRE((took > 0 || errno == EAGAIN));
        if (took > 0) written += static_cast<std::size_t>(took), next = static_cast<std::uint8_t>(next + took);
      }
      loop.restart();
      loop.poll();
      return taken == 6000;
    }));
    ::close(host);
    line->set_plugged(false);
    CHECK(line->terminal().empty());
    line->set_plugged(true);
  }
}
