// What the virtual room costs in processor time: one picture of 1920 x 1080 with 100 robots, its JPEG, and a whole
// second of the room with 15 of both. One core: OpenCV is told to use no other.
#include <benchmark/benchmark.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "emulator/room.hpp"
#include "hal/config.hpp"

namespace {

using namespace arkmesh;
using emulator::Room;

Room hundred() {
  cv::setNumThreads(1);
  return Room(hal::Config::from_file(std::string(ARKMESH_SOURCE_DIR) + "/experiments/room/hundred.toml").root());
}

void picture(benchmark::State& state) {
  Room room = hundred();
  room.advance_to(std::chrono::seconds(3));
  cv::Mat out;
  for (auto _ : state) room.picture(0, out);
}

void jpeg(benchmark::State& state) {
  Room room = hundred();
  room.advance_to(std::chrono::seconds(3));
  cv::Mat out;
  room.picture(0, out);
  std::vector<std::uint8_t> bytes;
  for (auto _ : state) cv::imencode(".jpg", out, bytes, {cv::IMWRITE_JPEG_QUALITY, room.config().jpeg_quality});
}

// Below 1000 ms it is faster than life.
void second_of_the_room(benchmark::State& state) {
  Room room = hundred();
  room.advance_to(std::chrono::seconds(3));
  cv::Mat out;
  std::vector<std::uint8_t> bytes;
  for (auto _ : state)
    for (int k = 0; k < 15; ++k) {
      room.advance_to(room.now() + room.config().frame_period);
      room.picture(0, out);
      cv::imencode(".jpg", out, bytes, {cv::IMWRITE_JPEG_QUALITY, room.config().jpeg_quality});
    }
}

BENCHMARK(picture)->Unit(benchmark::kMillisecond);
BENCHMARK(jpeg)->Unit(benchmark::kMillisecond);
BENCHMARK(second_of_the_room)->Unit(benchmark::kMillisecond)->Iterations(5);

}  // namespace

BENCHMARK_MAIN();
