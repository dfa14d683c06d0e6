// How well robots are followed: renders an emulated testbed frame by frame, tracks it as a lab would, and compares with
// the truth. track_emulated EMULATOR.toml [SECONDS] [--lapses] [--calibration FILE] [--jpeg QUALITY] Who is who is
// taken from the truth, as tests/support/emulated/tracking_referee.hpp says.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "emulator/emulator.hpp"
#include "hal/config/config.hpp"
#include "testbed/kilobot_settings.hpp"
#include "tests/support/emulated/fitted_cameras.hpp"
#include "tests/support/emulated/tracking_referee.hpp"
#include "tracker/camera/calibration_file.hpp"

namespace {

using namespace arkmesh;

struct Options {
  std::string emulator;
  double seconds = 60;
  bool lapses = false;      // says of each what happened
  std::string calibration;  // of that file in place of the true one,
  int boards = 0;           // or fitted to so many pictures of a chessboard and to marks clicked by hand
  bool by_turns = false;    // each camera takes its pictures at a time of its own: one picture at each look
  std::string robots;       // a file of `arkmesh fit robots`
  std::optional<int> jpeg;  // pictures go through JPEG of that quality, as through a camera's stream
};

// Processor time of this thread.
double cpu_s() {
  timespec at{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

std::vector<tracker::Calibration> calibrations_of(const emulator::Emulator& emulator, const Options& options) {
  const emulator::Scene& scene = emulator.config().scene;
  std::vector<tracker::Calibration> cameras;
  for (std::size_t k = 0; k < emulator.cameras(); ++k) {
    if (options.boards > 0) {
      const tests::FittedCamera fitted = tests::fit_by_hand(emulator, k, {.boards = options.boards});
      cameras.push_back(fitted.calibration);
      fmt::print(
          "{}: lens to {:.2f} px, marks to {:.2f} px = {:.2f} mm; {:.2f} mm off the truth at worst, {:.2f} mm away "
          "from the border\n",
          emulator.camera(k).settings().name, fitted.lens_error_px, fitted.marks_error_px, fitted.marks_error_mm,
          fitted.worst_mm, fitted.worst_within_mm);
    } else if (options.calibration.empty())
      cameras.push_back(tests::true_calibration(emulator.camera(k).model_at_first(), scene.width_m, scene.height_m));
    else
      cameras.emplace_back(tracker::read_calibration(options.calibration, emulator.camera(k).settings().name).data);
  }
  return cameras;
}

void through_jpeg(cv::Mat& picture, int quality) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  picture = cv::imdecode(bytes, cv::IMREAD_COLOR);
}

void print(const tests::TrackingScore& score) {
  const auto percent = [&](std::uint64_t part) {
    return 100 * static_cast<double>(part) / static_cast<double>(score.robot_frames);
  };
  const double seen = static_cast<double>(score.seen);
  fmt::print(
      "  tracked               {:.4f} % of robot-frames ({:.4f} % without doubt, {:.4f} % seen in the frame itself)\n",
      percent(score.tracked), percent(score.sure), percent(score.seen));
  fmt::print("  wrong ids             {} robot-frames, and {} of doubtful tracks, on which nobody acts\n", score.wrong,
             score.wrong_doubted);
  fmt::print("  strangers             {} track-frames with no robot there, {} on a robot that has a track already\n",
             score.strangers, score.twice);
  fmt::print("  named                 {} times\n", score.namings);
  fmt::print("  centre RMS            {:.3f} mm (mean {:.3f}, {:.3f}; worst {:.2f})\n", score.centre_rms_mm(),
             1000 * score.sum_x_m / seen, 1000 * score.sum_y_m / seen, 1000 * score.max_m);
  fmt::print("  heading RMS, LED on   {:.2f} degrees ({} looks)\n", score.heading_rms_deg(), score.headings);
  fmt::print("  (error / stated)^2    {:.2f}, each robot counted once\n", score.stated_square());
  for (std::size_t i = 0; i < 2; ++i)
    if (const auto& dark = score.dark[i]; dark.headings > 0)
      fmt::print("  heading RMS, LED off  {:.1f} degrees, (error / stated)^2 {:.2f}, {} ({} looks)\n",
                 std::sqrt(dark.square_rad / static_cast<double>(dark.headings)) * 180 / std::numbers::pi,
                 dark.stated_square / static_cast<double>(dark.headings), i == 0 ? "free" : "touching", dark.headings);
  fmt::print("  LED colour right      {:.2f} % of those seen\n", score.led_right_percent());
  constexpr std::string_view names[] = {"off", "red", "green", "yellow", "blue", "magenta", "cyan", "white"};
  for (std::size_t is = 0; is < 8; ++is) {
    std::string row;
    for (std::size_t seems = 0; seems < 8; ++seems)
      if (score.led[is][seems]) row += fmt::format(" {} {}", names[seems], score.led[is][seems]);
    if (!row.empty()) fmt::print("    {:<8} seen as{}\n", names[is], row);
  }
}

int measure(const Options& options) {
  const hal::Config config = hal::Config::from_file(options.emulator);
  emulator::Emulator emulator(config.root());
  tracker::ArenaTrackerSettings settings = testbed::kilobot_tracking();
  settings.expected_robots = static_cast<std::size_t>(emulator.robots());
  settings.following.half_width_m = emulator.config().scene.width_m / 2;
  settings.following.half_height_m = emulator.config().scene.height_m / 2;
  if (!options.robots.empty()) settings.following.led_offsets = testbed::read_led_offsets(options.robots);
  tracker::ArenaTracker tracking(calibrations_of(emulator, options), settings);

  tests::TrackingReferee referee;
  std::vector<cv::Mat> pictures(emulator.cameras());
  double tracking_s = 0;
  const double begun_s = cpu_s();
  const hal::LabTime period = emulator.config().frame_period;
  std::int64_t frame = 0;
  // The overhead controller needs two seconds to start; then the robots run.
  emulator.advance_to(hal::LabTime(3'000'000));
  emulator.command("say run");
  const hal::LabTime begun = emulator.now();
  for (; static_cast<double>((frame * period).count()) * 1e-6 < options.seconds; ++frame) {
    // all cameras at once, or one after the other
    const std::size_t turns = options.by_turns ? emulator.cameras() : 1;
    for (std::size_t turn = 0; turn < turns; ++turn) {
      emulator.advance_to(begun + (frame * static_cast<std::int64_t>(turns) + static_cast<std::int64_t>(turn)) *
                                      period / static_cast<std::int64_t>(turns));
      for (std::size_t k = 0; k < emulator.cameras(); ++k) {
        if ((options.by_turns && k != turn) || !emulator.picture(k, pictures[k]))
          pictures[k].release();
        else if (options.jpeg)
          through_jpeg(pictures[k], *options.jpeg);
      }
      const double before_s = cpu_s();
      tracking.look(emulator.now(), pictures);
      tracking_s += cpu_s() - before_s;
      referee.judge(emulator.now(), emulator.truth(), tracking);
    }
  }
  fmt::print("{} robots, {} frames ({:.0f} s), {} camera(s)\n", emulator.robots(), frame, options.seconds,
             emulator.cameras());
  print(referee.score());
  const double frames = static_cast<double>(frame);
  fmt::print("  tracking              {:.2f} ms of processor time a frame; the emulator itself {:.2f} ms\n",
             1000 * tracking_s / frames, 1000 * (cpu_s() - begun_s - tracking_s) / frames);
  for (const auto& [name, total] : tracking.counters().all()) fmt::print("  {:<21} {}\n", name, total);
  if (options.lapses)
    for (const std::string& lapse : referee.lapses()) fmt::print("{}\n", lapse);
  return 0;
}

Options read(int argc, char** argv) {
  Options options;
  int place = 0;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    const bool more = i + 1 < argc;
    if (word == "--lapses")
      options.lapses = true;
    else if (word == "--calibration" && more)
      options.calibration = argv[++i];
    else if (word == "--by-turns")
      options.by_turns = true;
    else if (word == "--by-hand" && more)
      options.boards = std::atoi(argv[++i]);
    else if (word == "--robots" && more)
      options.robots = argv[++i];
    else if (word == "--jpeg" && more)
      options.jpeg = std::atoi(argv[++i]);
    else if (place++ == 0)
      options.emulator = word;
    else
      options.seconds = std::atof(argv[i]);
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = read(argc, argv);
  if (options.emulator.empty() || !(options.seconds > 0)) {
    fmt::print(
        stderr,
        "track_emulated EMULATOR.toml [SECONDS] [--lapses] [--calibration FILE | --by-hand BOARDS] [--jpeg QUALITY] "
        "[--by-turns] [--robots FILE]\n");
    return 2;
  }
  try {
    return measure(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "track_emulated: {}\n", error.what());
    return 1;
  }
}
