// How long one core takes from a decoded frame to the robots on it, beside OpenCV's HoughCircles on the same frame in the same run.
// Frames are composed of robots cut from real pictures. Reading JPEG is timed apart.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/support/collage.hpp"
#include "tracker/detector.hpp"
#include "tracker/table_tracker.hpp"

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

// From the decoded frame to poses in the arena, lens distortion and parallax taken off, a whole search each tenth frame.
void whole_way(benchmark::State& state) {
  cv::setNumThreads(1);
  const tests::Scene& scene = frame(static_cast<int>(state.range(0)));
  constexpr double focal_px = 2000;
  tracker::CameraData data;
  data.lens = {.width_px = scene.bgr.cols, .height_px = scene.bgr.rows, .distortion = {-0.02, 0, 0, 0}};
  const double matrix[] = {focal_px, 0, scene.bgr.cols / 2.0, 0, focal_px, scene.bgr.rows / 2.0, 0, 0, 1}, down[] = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  std::copy(std::begin(matrix), std::end(matrix), std::begin(data.lens.matrix));
  std::copy(std::begin(down), std::end(down), std::begin(data.rotation));
  // as high as robots of that size ask for
  const tracker::TableSettings settings;
  data.translation_m[2] = focal_px * settings.body.diameter_m / (2 * scene.robots[0].r_px) + settings.body.board_m;
  data.arena_width_m = data.arena_height_m = 3;
  tracker::TableTracker table({tracker::Calibration(data)}, settings);
  hal::LabTime now{0};
  const auto look = [&] { return table.look(now += hal::LabTime{66'667}, std::span(&scene.bgr, 1)).size(); };
  for (int i = 0; i < 10; ++i) look();
  std::size_t tracks = 0;
  for (auto _ : state) tracks = look();
  state.counters["tracks"] = static_cast<double>(tracks);
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
BENCHMARK(whole_way)->Arg(100)->Arg(250)->Iterations(200)->Unit(benchmark::kMillisecond);
BENCHMARK(read_jpeg)->Arg(100)->Arg(250)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
