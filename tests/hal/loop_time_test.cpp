#include "hal/time/loop_time.hpp"

#include <doctest/doctest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <cstdint>
#include <ctime>

#include "hal/event_loop.hpp"

using namespace arkmesh::hal;
using namespace std::chrono_literals;

TEST_CASE("loop time: to wait with nothing on the loop costs no processor time") {
  // Runs of paced arenas wait so; they used to keep a core busy.
  EventLoop loop;
  LoopTime time(loop);
  const std::clock_t before = std::clock();
  const TimePoint then = time.now() + 300ms;
  time.wait_until(then);
  CHECK(time.now() >= then);
  CHECK(static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC < 0.1);
}

TEST_CASE("loop time: who floods the loop does not keep the program from going on") {
  EventLoop loop;
  LoopTime time(loop);
  struct Flood {
    EventLoop& loop;
    std::uint64_t served = 0;
    void go_on() {
      ++served;
      boost::asio::post(loop, [this] { go_on(); });
    }
  } flood{loop};
  flood.go_on();
  for (int i = 0; i < 5; ++i) {
    const std::uint64_t before = flood.served;
    time.serve();  // comes back
    CHECK(flood.served > before);
  }
  const TimePoint then = time.now() + 20ms;
  time.wait_until(then);
  CHECK(time.now() >= then);
}
