// Cameras that look aslant through bent lenses and overlap: their pictures give one track for each robot, where it
// truly is.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <fstream>

#include "hal/config/config.hpp"
#include "testbed/kilobot_settings.hpp"
#include "tests/support/emulated/fitted_cameras.hpp"
#include "tests/support/emulated/tracking_referee.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;

namespace {

// 0.9 m x 0.5 m with 20 walking robots, each with its LED elsewhere; each camera sees a little more than its half, one
// of them at 24 degrees.
hal::Config two_cameras(const std::filesystem::path& robots_file) {
  return hal::Config::from_text(
      "[emulator]\nframes_per_s = 10.0\n"
      "[[emulator.camera]]\nname = \"west\"\nwidth_px = 800\nheight_px = 600\nx_m = -0.62\ny_m = 0.0\nz_m = "
      "1.0\nlook_x_m "
      "= -0.18\n"
      "look_y_m = 0.0\nfocal_px = 1000.0\ndistortion = [-0.25, 0.08, 0.0003, -0.0002, 0.0]\n"
      "[[emulator.camera]]\nname = \"east\"\nwidth_px = 800\nheight_px = 600\nx_m = 0.2\ny_m = 0.02\nz_m = "
      "1.0\nfocal_px = "
      "1100.0\n"
      "distortion = [-0.08, 0.02, 0.0, 0.0, 0.0]\n"
      "[arena]\nwidth_m = 0.9\nheight_m = 0.5\nrobots = 20\n"
      "[arena.ode]\ncontroller = \"" ARKMESH_SOURCE_DIR "/experiments/emulator/walker.c\"\nrobots_file = \"" +
          robots_file.string() + "\"\n",
      "two_cameras.toml");
}

}  // namespace

// LEDs 35 to 72 degrees to the right of ahead, as measured to a degree.
void write_robots(const std::filesystem::path& file) {
  std::ofstream out(file);
  for (int i = 0; i < 20; ++i)
    out << fmt::format("[[robot]]\nid = {}\nled_bearing_deg = {:.1f}\nled_bearing_error_deg = 1\n", i,
                       -35 - 37.0 * (i * 7 % 20) / 19);
}

TEST_CASE("a camera that looks aslant and one beside it give each robot one track, within a millimetre") {
  // Proves that robots are followed across the seam with their names, and that a camera that is gone brings no invented
  // poses: the robots that only it sees are no longer reported, the others go on, and all are back when it is. Headings
  // are as far off as is stated where nobody knows each robot's LED, and right where it was measured.
  const tests::TemporaryDirectory folder;
  const auto robots_file = folder.path() / "robots.toml";
  write_robots(robots_file);
  emulator::Emulator emulator(two_cameras(robots_file).root());
  std::vector<tracker::Calibration> cameras;
  for (std::size_t k = 0; k < emulator.cameras(); ++k)
    cameras.push_back(tests::true_calibration(emulator.camera(k).model(), 0.9, 0.5));
  tracker::ArenaTrackerSettings settings = testbed::kilobot_tracking();
  settings.expected_robots = 20;
  tracker::ArenaTracker unaware(cameras, settings);
  settings.following.led_offsets = testbed::read_led_offsets(robots_file);
  tracker::ArenaTracker tracker(std::move(cameras), settings);
  tests::TrackingReferee referee, of_unaware;
  emulator.advance_to(hal::LabTime{3'000'000});
  emulator.command("say run");
  std::vector<cv::Mat> pictures(2);
  const auto watch = [&](int frames) {
    for (int frame = 0; frame < frames; ++frame) {
      emulator.advance_to(emulator.now() + emulator.config().frame_period);
      for (std::size_t k = 0; k < pictures.size(); ++k)
        if (!emulator.picture(k, pictures[k])) pictures[k].release();
      tracker.look(emulator.now(), pictures);
      referee.judge(emulator.now(), emulator.truth(), tracker);
      if (frames < 80) continue;
      unaware.look(emulator.now(), pictures);
      of_unaware.judge(emulator.now(), emulator.truth(), unaware);
    }
  };
  watch(80);
  CAPTURE(of_unaware.score().heading_rms_deg());
  CHECK(of_unaware.score().heading_rms_deg() > 10);
  CHECK(of_unaware.score().stated_square() > 0.7);
  CHECK(of_unaware.score().stated_square() < 1.5);
  CHECK(referee.score().tracked_percent() > 99);
  CHECK(referee.score().wrong == 0);
  CHECK(referee.score().twice == 0);
  CHECK(referee.score().strangers == 0);
  CHECK(referee.score().centre_rms_mm() < 1);
  CHECK(referee.score().heading_rms_deg() < 5);

  REQUIRE(emulator.command("camera west gone") == "ok");
  watch(15);
  const std::size_t left = tracker.tracks().size();
  CHECK(left > 4);
  CHECK(left < 20);
  REQUIRE(emulator.command("camera west ok") == "ok");
  watch(30);
  CHECK(tracker.tracks().size() == 20);
  CHECK(referee.score().wrong == 0);
  CHECK(referee.score().strangers == 0);
}
