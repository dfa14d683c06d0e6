#include "hal/loop_time.hpp"

#include <doctest/doctest.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
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
