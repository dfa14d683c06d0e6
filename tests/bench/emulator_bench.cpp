// What the emulated testbed costs in processor time: one picture of 1920 x 1080 with 100 robots, its JPEG, and a whole
// second of the emulator with 15 of both. One core: OpenCV is told to use no other.
#include <benchmark/benchmark.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "emulator/emulator.hpp"
#include "hal/config/config.hpp"

namespace {

using namespace arkmesh;
using emulator::Emulator;

Emulator hundred() {
  cv::setNumThreads(1);
  return Emulator(
      hal::Config::from_file(std::string(ARKMESH_SOURCE_DIR) + "/experiments/emulator/hundred.toml").root());
}

void picture(benchmark::State& state) {
  Emulator emulator = hundred();
  emulator.advance_to(std::chrono::seconds(3));
  cv::Mat out;
  for (auto _ : state) emulator.picture(0, out);
}

void jpeg(benchmark::State& state) {
  Emulator emulator = hundred();
  emulator.advance_to(std::chrono::seconds(3));
  cv::Mat out;
  emulator.picture(0, out);
  std::vector<std::uint8_t> bytes;
  for (auto _ : state) cv::imencode(".jpg", out, bytes, {cv::IMWRITE_JPEG_QUALITY, emulator.config().jpeg_quality});
}

// Below 1000 ms it is faster than life.
void second_of_the_emulator(benchmark::State& state) {
  Emulator emulator = hundred();
  emulator.advance_to(std::chrono::seconds(3));
  cv::Mat out;
  std::vector<std::uint8_t> bytes;
  for (auto _ : state)
    for (int k = 0; k < 15; ++k) {
      emulator.advance_to(emulator.now() + emulator.config().frame_period);
      emulator.picture(0, out);
      cv::imencode(".jpg", out, bytes, {cv::IMWRITE_JPEG_QUALITY, emulator.config().jpeg_quality});
    }
}

BENCHMARK(picture)->Unit(benchmark::kMillisecond);
BENCHMARK(jpeg)->Unit(benchmark::kMillisecond);
BENCHMARK(second_of_the_emulator)->Unit(benchmark::kMillisecond)->Iterations(5);

}  // namespace

BENCHMARK_MAIN();
