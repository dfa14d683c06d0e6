// How long one core takes from a decoded frame to the robots on it, beside OpenCV's HoughCircles on the same frame in the same run.
// Frames are composed of robots cut from real pictures. Reading JPEG is timed apart.
#include <benchmark/benchmark.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/support/picture_changes.hpp"
#include "tracker/detector.hpp"

namespace {

using namespace arkmesh;

// 100 robots on one frame of a square metre; 250 on each of four frames that see a larger table together.
const tests::Scene& frame(int robots) {
  static const auto make = [](int count, double diameter_px, unsigned seed) {
    return tests::collage(tests::real_scenes(), {.width_px = 2048, .height_px = 1536, .robots = count, .diameter_px = diameter_px,
                                                 .touching = true, .distractors = true, .seed = seed});
  };
  static const tests::Scene few = make(100, 50, 3), many = make(250, 32, 4);
  return robots == 100 ? few : many;
}

std::vector<tracker::Expected> where_they_were(const tests::Scene& scene) {
  std::vector<tracker::Expected> where;
  // a robot drives a centimetre a second: a few pixels a frame at most
  for (std::size_t i = 0; i < scene.robots.size(); ++i)
    where.push_back(
        {scene.robots[i].x_px + (i % 3) - 1.0, scene.robots[i].y_px + (i % 5) - 2.0, scene.robots[i].r_px, 0.35 * scene.robots[i].r_px});
  return where;
}

void count_found(benchmark::State& state, const std::vector<tracker::Detection>& found, const tests::Scene& scene) {
  const tests::Score score = tests::score(found, scene.robots);
  state.counters["precision"] = score.precision();
  state.counters["recall"] = score.recall();
}

// OpenCV's circles with the radius known: blur 1 px, Canny 90, 24 votes, 0.8 to 1.15 of the radius, 1.6 radii apart.
void hough_circles(benchmark::State& state) {
  cv::setNumThreads(1);
  const tests::Scene& scene = frame(static_cast<int>(state.range(0)));
  const double r_px = scene.robots[0].r_px;
  std::vector<cv::Vec3f> circles;
  for (auto _ : state) {
    cv::Mat grey;
    cv::cvtColor(scene.bgr, grey, cv::COLOR_BGR2GRAY);
    cv::GaussianBlur(grey, grey, {}, 1.0);
    cv::HoughCircles(grey, circles, cv::HOUGH_GRADIENT, 1, 1.6 * r_px, 90, 24, static_cast<int>(0.8 * r_px), static_cast<int>(1.15 * r_px));
  }
  std::vector<tracker::Detection> found;
  for (const cv::Vec3f& circle : circles) found.push_back({circle[0], circle[1], circle[2]});
  count_found(state, found, scene);
}

void first_search(benchmark::State& state) {
  cv::setNumThreads(1);
  const tests::Scene& scene = frame(static_cast<int>(state.range(0)));
  std::vector<tracker::Detection> found;
  for (auto _ : state) found = tracker::Detector().search(scene.bgr);
  count_found(state, found, scene);
}

void search(benchmark::State& state) {
  cv::setNumThreads(1);
  const tests::Scene& scene = frame(static_cast<int>(state.range(0)));
  tracker::Detector detector;
  std::vector<tracker::Detection> found = detector.search(scene.bgr);
  for (auto _ : state) found = detector.search(scene.bgr);
  count_found(state, found, scene);
}

void follow(benchmark::State& state) {
  cv::setNumThreads(1);
  const tests::Scene& scene = frame(static_cast<int>(state.range(0)));
  const std::vector<tracker::Expected> where = where_they_were(scene);
  tracker::Detector detector;
  std::vector<std::optional<tracker::Detection>> seen;
  for (auto _ : state) seen = detector.follow(scene.bgr, where);
  std::vector<tracker::Detection> found;
  for (const auto& one : seen)
    if (one) found.push_back(*one);
  count_found(state, found, scene);
}

// Nine frames followed, one searched: the time is that of a frame on average.
void ten_frames(benchmark::State& state) {
  cv::setNumThreads(1);
  const tests::Scene& scene = frame(static_cast<int>(state.range(0)));
  const std::vector<tracker::Expected> where = where_they_were(scene);
  tracker::Detector detector;
  detector.search(scene.bgr);
  for (std::size_t number = 0; auto _ : state) {
    if (number++ % 10 == 0) benchmark::DoNotOptimize(detector.search(scene.bgr));
    else benchmark::DoNotOptimize(detector.follow(scene.bgr, where));
  }
}

void read_jpeg(benchmark::State& state) {
  cv::setNumThreads(1);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", frame(static_cast<int>(state.range(0))).bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, 90});
  for (auto _ : state) benchmark::DoNotOptimize(cv::imdecode(bytes, cv::IMREAD_COLOR));
}

BENCHMARK(hough_circles)->Arg(100)->Arg(250)->Unit(benchmark::kMillisecond);
BENCHMARK(first_search)->Arg(100)->Arg(250)->Unit(benchmark::kMillisecond);
BENCHMARK(search)->Arg(100)->Arg(250)->Unit(benchmark::kMillisecond);
BENCHMARK(follow)->Arg(100)->Arg(250)->Unit(benchmark::kMillisecond);
// a multiple of ten, so that searches have their share
BENCHMARK(ten_frames)->Arg(100)->Arg(250)->Iterations(200)->Unit(benchmark::kMillisecond);
BENCHMARK(read_jpeg)->Arg(100)->Arg(250)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
