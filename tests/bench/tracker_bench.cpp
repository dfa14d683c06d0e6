// How long one core takes from a decoded frame to the robots on it, beside OpenCV's HoughCircles on the same frame in
// the same run. Frames are composed of robots cut from real pictures. Reading JPEG is timed apart.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "hal/config/config.hpp"
#include "testbed/kilobot_tracking.hpp"
#include "tests/bench/arena_film.hpp"
#include "tests/support/emulated/fitted_cameras.hpp"
#include "tests/support/emulated/tracking_referee.hpp"
#include "tests/support/pictures/collage.hpp"
#include "tracker/detect/detector.hpp"
#include "tracker/follow/marker_tracker.hpp"

namespace {

using namespace arkmesh;

// 100 robots on one frame of a square metre; 250 on each of four frames that see a larger arena together.
const tests::Scene& frame(int robots) {
  static const auto make = [](int count, double diameter_px, unsigned seed) {
    return tests::collage(tests::real_scenes(), {.width_px = 2048,
                                                 .height_px = 1536,
                                                 .robots = count,
                                                 .diameter_px = diameter_px,
                                                 .touching = true,
                                                 .distractors = true,
                                                 .seed = seed});
  };
  static const tests::Scene few = make(100, 50, 3), many = make(250, 32, 4);
  return robots == 100 ? few : many;
}

std::vector<tracker::Expected> where_they_were(const tests::Scene& scene) {
  std::vector<tracker::Expected> where;
  // a robot drives a centimetre a second: a few pixels a frame at most
  for (std::size_t i = 0; i < scene.robots.size(); ++i)
    where.push_back({scene.robots[i].x_px + (i % 3) - 1.0, scene.robots[i].y_px + (i % 5) - 2.0, scene.robots[i].r_px,
                     0.35 * scene.robots[i].r_px});
  return where;
}

void count_found(benchmark::State& state, const std::vector<tracker::Detection>& found, const tests::Scene& scene) {
  const tests::Score score = tests::score(found, scene.robots);
  state.counters["precision"] = score.precision();
  state.counters["recall"] = score.recall();
}

// OpenCV's circles with the radius known: blur 1 px, Canny 90, 24 votes, 0.8 to 1.15 of the radius, 1.6 radii apart.
std::vector<cv::Vec3f> hough(const cv::Mat& bgr, double r_px) {
  std::vector<cv::Vec3f> circles;
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, grey, {}, 1.0);
  cv::HoughCircles(grey, circles, cv::HOUGH_GRADIENT, 1, 1.6 * r_px, 90, 24, static_cast<int>(0.8 * r_px),
                   static_cast<int>(1.15 * r_px));
  return circles;
}

void hough_circles(benchmark::State& state) {
  cv::setNumThreads(1);
  const tests::Scene& scene = frame(static_cast<int>(state.range(0)));
  const double r_px = scene.robots[0].r_px;
  std::vector<cv::Vec3f> circles;
  for (auto _ : state) circles = hough(scene.bgr, r_px);
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
    if (number++ % 10 == 0)
      benchmark::DoNotOptimize(detector.search(scene.bgr));
    else
      benchmark::DoNotOptimize(detector.follow(scene.bgr, where));
  }
}

double cpu_s() {
  timespec at{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

// 100 Kilobots that walk in 1 m2 before one camera of 2048 x 1536 that hangs a little aslant and has a wide lens.
hal::Config square_metre() {
  return hal::Config::from_text(
      "[emulator]\nseed = 3\n"
      "[emulator.scene]\ndistractors = true\n"
      "[[emulator.camera]]\nname = \"camera0\"\nwidth_px = 2048\nheight_px = 1536\nx_m = 0.06\ny_m = -0.05\n"
      "z_m = 1.4\nlook_x_m = 0.0\nlook_y_m = 0.0\ndistortion = [-0.1, 0.03, 0.0004, -0.0006, 0.0]\n"
      "[arena]\nrobots = 100\n"
      "[arena.ode]\ncontroller = \"" ARKMESH_SOURCE_DIR "/experiments/emulator/walker.c\"\n",
      "square_metre.toml");
}

// From the decoded frame to poses in the arena, lens distortion and parallax taken off, a whole search each tenth
// frame; and HoughCircles on each of the same frames, by turns. The time is ours, of the processor; the counters say
// how many times as long HoughCircles takes.
void whole_way(benchmark::State& state, bench::Robots robots) {
  cv::setNumThreads(1);
  bench::ArenaFilm film(square_metre(), robots);
  tracker::ArenaTrackerSettings settings = testbed::kilobot_tracking();
  settings.expected_robots = static_cast<std::size_t>(film.emulator().robots());
  tracker::ArenaTracker tracking({tests::true_calibration(film.emulator().camera(0).model(), 1, 1)}, settings);
  tests::TrackingReferee referee;
  const double r_px = film.robot_radius_px(0);
  double ours_s = 0, hough_s = 0;
  const auto look = [&] {
    film.next();
    const double before_s = cpu_s();
    tracking.look(film.now(), film.pictures());
    const double took_s = cpu_s() - before_s;
    referee.judge(film.now(), film.emulator().truth(), tracking);
    return took_s;
  };
  // All are found and followed before time is taken.
  for (int i = 0; i < 20; ++i) look();
  std::size_t circles = 0;
  for (auto _ : state) {
    const double took_s = look();
    state.SetIterationTime(took_s);
    ours_s += took_s;
    const double before_s = cpu_s();
    circles += hough(film.pictures()[0], r_px).size();
    hough_s += cpu_s() - before_s;
  }
  const double frames = static_cast<double>(state.iterations());
  state.counters["hough_ms"] = 1000 * hough_s / frames;
  state.counters["times_faster"] = hough_s / ours_s;
  state.counters["circles"] = static_cast<double>(circles) / frames;
  state.counters["tracked_percent"] = referee.score().tracked_percent();
  state.counters["wrong_ids"] = static_cast<double>(referee.score().wrong);
  state.counters["robot_px"] = 2 * r_px;
}

// 1000 robots under four cameras: from four decoded pictures to poses, and reading the four pictures' JPEG, by turns.
// The time is that of the tracking, of one processor, for a set of four; at 10 sets/s two cores have 200 ms for each.
void whole_arena(benchmark::State& state, int sets_before) {
  cv::setNumThreads(1);
  bench::ArenaFilm film(hal::Config::from_file(ARKMESH_SOURCE_DIR "/experiments/emulator/thousand.toml"),
                        bench::Robots::drawn);
  const auto& scene = film.emulator().config().scene;
  std::vector<tracker::Calibration> cameras;
  for (std::size_t k = 0; k < film.emulator().cameras(); ++k)
    cameras.push_back(tests::true_calibration(film.emulator().camera(k).model(), scene.width_m, scene.height_m));
  tracker::ArenaTrackerSettings settings = testbed::kilobot_tracking();
  settings.expected_robots = static_cast<std::size_t>(film.emulator().robots());
  tracker::ArenaTracker tracking(std::move(cameras), settings);
  tests::TrackingReferee referee;
  const auto look = [&] {
    film.next();
    const double before_s = cpu_s();
    tracking.look(film.now(), film.pictures());
    const double took_s = cpu_s() - before_s;
    referee.judge(film.now(), film.emulator().truth(), tracking);
    return took_s;
  };
  // Those that the first searches overlook are found in the next ones.
  for (int i = 0; i < sets_before; ++i) look();
  std::vector<std::vector<std::uint8_t>> jpegs(film.pictures().size());
  double ours_s = 0, max_s = 0, jpeg_s = 0;
  for (auto _ : state) {
    const double took_s = look();
    state.SetIterationTime(took_s);
    ours_s += took_s;
    max_s = std::max(max_s, took_s);
    for (std::size_t k = 0; k < jpegs.size(); ++k)
      cv::imencode(".jpg", film.pictures()[k], jpegs[k], {cv::IMWRITE_JPEG_QUALITY, 90});
    const double before_s = cpu_s();
    for (const auto& jpeg : jpegs) benchmark::DoNotOptimize(cv::imdecode(jpeg, cv::IMREAD_COLOR));
    jpeg_s += cpu_s() - before_s;
  }
  const double sets = static_cast<double>(state.iterations()), tracking_ms = 1000 * ours_s / sets,
               reading_ms = 1000 * jpeg_s / sets;
  const tests::TrackingScore& score = referee.score();
  state.counters["longest_ms"] = 1000 * max_s;
  state.counters["read_jpegs_ms"] = reading_ms;
  state.counters["free_percent"] = 100 * (1 - (tracking_ms + reading_ms) / 200);
  state.counters["tracked_percent"] = score.tracked_percent();
  state.counters["wrong_ids"] = static_cast<double>(score.wrong);
  state.counters["twice"] = static_cast<double>(score.twice);
  state.counters["strangers"] = static_cast<double>(score.strangers);
  state.counters["centre_rms_mm"] = score.centre_rms_mm();
}

// 12 Thymios that walk before one camera of 2048 x 1536, with markers of 40 pixels: from the decoded frame to poses.
void markers(benchmark::State& state) {
  cv::setNumThreads(1);
  bench::ArenaFilm film(hal::Config::from_text("[emulator]\nseed = 3\nexposure_s = 0.005\nframes_per_s = 10\n"
                                               "[emulator.scene]\nmarker_m = 0.05\n"
                                               "[[emulator.camera]]\nwidth_px = 2048\nheight_px = 1536\nx_m = 0.06\n"
                                               "y_m = -0.05\nz_m = 2.88\nlook_x_m = 0.0\nlook_y_m = 0.0\n"
                                               "distortion = [-0.1, 0.03, 0.0004, -0.0006, 0.0]\n"
                                               "[arena]\nwidth_m = 2.45\nheight_m = 1.78\nrobots = 12\n"
                                               "[arena.ode]\nrobot = \"thymio\"\ncontroller = \"" ARKMESH_SOURCE_DIR
                                               "/scenarios/dhtf/controller/dhtf.c\"\n",
                                               "markers.toml"),
                        bench::Robots::drawn);
  const emulator::Scene& scene = film.emulator().config().scene;
  tracker::MarkerSettings settings{.side_m = scene.marker_m, .height_m = scene.robot_height_m};
  for (int i = 0; i < film.emulator().robots(); ++i) settings.robots.push_back(static_cast<hal::RobotId>(i));
  tracker::MarkerTracker tracking(
      {tests::true_calibration(film.emulator().camera(0).model(), scene.width_m, scene.height_m)}, settings);
  const auto look = [&] {
    film.next();
    return tracking.look(film.now(), film.pictures());
  };
  // All are found before time is taken.
  for (int i = 0; i < 20; ++i) look();
  std::size_t seen = 0;
  double farthest_m = 0, longest_s = 0;
  for (auto _ : state) {
    film.next();
    const double before_s = cpu_s();
    const std::vector<hal::Observation> robots = tracking.look(film.now(), film.pictures());
    const double took_s = cpu_s() - before_s;
    state.SetIterationTime(took_s);
    longest_s = std::max(longest_s, took_s);
    seen += robots.size();
    const auto truth = film.emulator().truth();
    for (const hal::Observation& robot : robots)
      farthest_m = std::max(farthest_m, std::hypot(robot.pose.x_m - truth[robot.robot].seen.pose.x_m,
                                                   robot.pose.y_m - truth[robot.robot].seen.pose.y_m));
  }
  const auto at = film.emulator().camera(0).model().project_near(0, 0, settings.height_m);
  state.counters["marker_px"] = settings.side_m * std::sqrt(std::abs(at->xx * at->yy - at->xy * at->yx));
  state.counters["seen_percent"] =
      100.0 * static_cast<double>(seen) / (static_cast<double>(state.iterations()) * film.emulator().robots());
  state.counters["farthest_mm"] = 1000 * farthest_m;
  state.counters["longest_ms"] = 1000 * longest_s;
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
BENCHMARK_CAPTURE(whole_way, photographed, bench::Robots::photographed)
    ->UseManualTime()
    ->Iterations(100)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_way, drawn, bench::Robots::drawn)
    ->UseManualTime()
    ->Iterations(100)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_arena, long, 30)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(markers)->UseManualTime()->Iterations(100)->Unit(benchmark::kMillisecond);
BENCHMARK(read_jpeg)->Arg(100)->Arg(250)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
