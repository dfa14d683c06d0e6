// The whole way from pictures to named robots: a real clip, several cameras, and a monitor over an emulated testbed.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "emulator/emulator.hpp"
#include "hal/config/config.hpp"
#include "testbed/arena_monitor.hpp"
#include "testbed/kilobot_row.hpp"
#include "testbed/kilobot_tracking.hpp"
#include "tests/support/processes/temporary_directory.hpp"
#include "tests/testbed/watched_emulator.hpp"
#include "tracker/camera/calibration_file.hpp"
#include "tracker/camera/source.hpp"
#include "tracker/follow/arena_tracker.hpp"

using namespace arkmesh;
using namespace arkmesh::tracker;
using namespace arkmesh::tests;

namespace {

const std::string pictures_folder = std::string(ARKMESH_TEST_DATA) + "/kilobot-images/";

struct TrueRobot {
  double x_px = 0, y_px = 0, r_px = 0;
};

// By frame and id.
std::map<std::uint32_t, std::map<int, TrueRobot>> true_tracks() {
  std::map<std::uint32_t, std::map<int, TrueRobot>> truth;
  std::ifstream in(pictures_folder + "bodyguard_clip_tracks.csv");
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    std::uint32_t frame = 0;
    int id = 0;
    TrueRobot robot;
    row >> frame >> id >> robot.x_px >> robot.y_px >> robot.r_px;
    truth[frame][id] = robot;
  }
  return truth;
}

CameraData camera_at(double x_m, double width_px = 900, double height_px = 900) {
  CameraData data;
  data.lens = {LensModel::pinhole,
               static_cast<int>(width_px),
               static_cast<int>(height_px),
               {900, 0, 449.5, 0, 900, 449.5, 0, 0, 1},
               {}};
  data.translation_m = {-x_m, 0, 1.0};
  return data;
}

Detection detection_at(const Calibration& camera, Point place, double offset_m = 0) {
  const auto pixel = camera.to_pixel({place.x + offset_m, place.y}, hal::kilobot::board_height_m);
  const double r_px = camera.scale(place, hal::kilobot::board_height_m)->largest * hal::kilobot::body_radius_m;
  const auto led = camera.to_pixel({place.x + offset_m, place.y + 0.014},
                                   hal::kilobot::board_height_m + hal::kilobot::led_above_board_m);
  return {.x_px = pixel->x,
          .y_px = pixel->y,
          .r_px = r_px,
          .confidence = 0.8f,
          .led = hal::Led::green,
          .led_confidence = 0.9f,
          .led_x_px = led->x,
          .led_y_px = led->y};
}

// Followed robots while they drive straight on for a second: their paths against their headings.
class StraightHeadings {
 public:
  void look(hal::LabTime now, const std::vector<Track>& tracks) {
    for (const Track& track : tracks) {
      std::vector<Look>& stretch = stretches_[track.number];
      if (!track.led_seen || track.led == hal::Led::off) stretch.clear();
      if (track.led_seen && track.led != hal::Led::off) stretch.push_back({now, track});
      if (stretch.empty() || now - stretch.front().at < hal::LabTime(1'000'000)) continue;
      judge(track.number, stretch);
      stretch.erase(stretch.begin(), stretch.begin() + 3);
    }
  }
  // Mean of (path - heading)^2 in units of what was stated, each robot counted once; of its noise alone.
  double square(bool noise_alone) const {
    double sum = 0;
    for (const auto& [number, each] : squares_) sum += each[noise_alone ? 1 : 0] / each[2];
    return sum / static_cast<double>(squares_.size());
  }
  std::size_t robots() const { return squares_.size(); }

 private:
  struct Look {
    hal::LabTime at;
    Track track;
  };
  // Both halves of the way are 4 mm or more, in directions within 10 degrees, and the LED turns as little.
  void judge(TrackNumber number, std::vector<Look>& stretch) {
    const auto way = [&](std::size_t from, std::size_t to) {
      const hal::Pose &a = stretch[from].track.in_arena, &b = stretch[to].track.in_arena;
      return std::array{std::hypot(b.x_m - a.x_m, b.y_m - a.y_m), std::atan2(b.y_m - a.y_m, b.x_m - a.x_m)};
    };
    const std::size_t last = stretch.size() - 1;
    const auto first_half = way(0, last / 2), second_half = way(last / 2, last);
    const Track& middle = stretch[last / 2].track;
    constexpr double straight_rad = 10 * std::numbers::pi / 180;
    if (std::min(first_half[0], second_half[0]) < 0.004 ||
        std::abs(wrapped(first_half[1] - second_half[1])) > straight_rad ||
        std::abs(wrapped(stretch[last].track.in_arena.heading_rad - stretch[0].track.in_arena.heading_rad)) >
            2 * straight_rad)
      return;
    const double off_rad = wrapped(way(0, last)[1] - middle.in_arena.heading_rad);
    auto& each = squares_[number];
    each[0] += std::pow(off_rad / middle.heading_sigma_rad, 2);
    each[1] += std::pow(off_rad / middle.heading_noise_rad, 2);
    each[2] += 1;
  }

  std::map<TrackNumber, std::vector<Look>> stretches_;
  std::map<TrackNumber, std::array<double, 3>> squares_;
};

std::string refusal(const std::string& text) {
  try {
    const auto config = hal::Config::from_text(text, "lab.toml");
    testbed::make_arena_monitor(lab_settings(config));
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("the real clip: 28 robots, no switch, nobody lost") {
  // Proves that every robot of all 242 frames is followed by one track from the first to the last, at four times life
  // speed, uncalibrated; and that what is stated of headings covers that nobody knows where each robot's LED is, which
  // the noise of looks does not.
  const auto truth = true_tracks();
  REQUIRE(truth.size() == 242);
  const auto clip = open_recording(pictures_folder + "bodyguard_clip.mp4");
  ArenaTracker tracker{testbed::kilobot_tracking()};
  std::map<int, std::set<TrackNumber>> tracks_of;
  StraightHeadings straight;
  std::size_t missing = 0, strangers = 0, doubtful = 0, frames = 0;
  while (const auto picture = clip->next()) {
    const auto& tracks = tracker.look(picture->stamp, std::span(&picture->bgr, 1));
    ++frames;
    straight.look(picture->stamp, tracks);
    std::set<TrackNumber> used;
    for (const auto& [id, robot] : truth.at(picture->number)) {
      const Track* nearest = nullptr;
      double min_px = robot.r_px / 2;
      for (const Track& track : tracks) {
        const auto at =
            tracker.calibration(0)->to_pixel({track.in_arena.x_m, track.in_arena.y_m}, hal::kilobot::board_height_m);
        const double off_px = std::hypot(at->x - robot.x_px, at->y - robot.y_px);
        if (off_px < min_px) min_px = off_px, nearest = &track;
      }
      if (!nearest) {
        ++missing;
        continue;
      }
      tracks_of[id].insert(nearest->number);
      used.insert(nearest->number);
      if (picture->number > 10) doubtful += nearest->doubtful;
    }
    strangers += tracks.size() - used.size();
  }
  CHECK(frames == 242);
  CHECK(missing == 0);
  CHECK(strangers == 0);
  CHECK(doubtful == 0);
  for (const auto& [id, tracks] : tracks_of) CHECK(tracks.size() == 1);
  MESSAGE(straight.robots(), " straight drivers: (error / stated)^2 ", straight.square(false));
  CHECK(straight.robots() > 5);
  CHECK(straight.square(false) > 0.7);
  CHECK(straight.square(false) < 1.5);
  CHECK(straight.square(true) > 10);
}

TEST_CASE("robots at a seam are one, neighbours stay two") {
  // Proves that views that differ by a few millimetres are brought together, weighted, and that bodies that touch are
  // not.
  const Body body = testbed::kilobot_body();
  const Calibration west(camera_at(-0.2)), east(camera_at(0.2));
  const Point a{0, 0}, b{0.034, 0};
  const std::vector<Detection> in_west = {detection_at(west, a), detection_at(west, b)};
  const std::vector<Detection> in_east = {detection_at(east, a, 0.004), detection_at(east, b, 0.004)};
  const std::vector<std::vector<FusedObservation>> views = {on_arena(west, in_west, body),
                                                            on_arena(east, in_east, body)};
  const auto fused = fuse(views, body);
  REQUIRE(fused.size() == 2);
  CHECK(fused[0].x_m == doctest::Approx(0.002).epsilon(0.05));
  CHECK(fused[1].x_m == doctest::Approx(0.036).epsilon(0.05));
  CHECK(fused[0].sigma_m < fuse(std::vector<std::vector<FusedObservation>>{views[0], {}}, body)[0].sigma_m);
  CHECK(fused[0].confidence == doctest::Approx(0.96));
  REQUIRE(fused[0].led_heading_rad.has_value());
  CHECK(*fused[0].led_heading_rad == doctest::Approx(std::numbers::pi / 2).epsilon(0.01));
  // What one camera sees alone stays, and what its picture's edge hides is left out.
  CHECK(fuse(std::vector<std::vector<FusedObservation>>{views[0], {}}, body).size() == 2);
  Detection edge = in_west[0];
  edge.x_px = 2;
  CHECK(on_arena(west, std::vector{edge}, body).empty());
}

TEST_CASE("a picture of another size than the calibration's is refused and counted") {
  // Proves that a camera that was switched to another resolution gives no wrong places.
  ArenaTracker tracker({Calibration(camera_at(0))}, testbed::kilobot_tracking());
  const cv::Mat picture(480, 640, CV_8UC3, cv::Scalar::all(128));
  CHECK(tracker.look(hal::LabTime(0), std::span(&picture, 1)).empty());
  CHECK(tracker.counters()["camera.refused.size"] == 1);
}

TEST_CASE("a monitor names the robots of an emulator, and again those that were exchanged by hand") {
  // Proves the whole way: question on the air, LEDs in pictures, names; nobody acts on either id while two robots are
  // exchanged under cover, and both are right again within 20 s.
  const arkmesh::tests::TemporaryDirectory folder;
  EmulatedTestbed testbed(emulator_text());
  const auto monitor = testbed.monitor(lab_text(folder.path() / "testbed.yaml"), folder.path() / "testbed.yaml");
  int looks = 0;
  for (; looks < 200 && !monitor->everybody_named(); ++looks) {
    testbed.next(*monitor);
    CHECK(testbed.wrong_ids(*monitor) == 0);
  }
  REQUIRE(monitor->everybody_named());
  MESSAGE("8 robots named after ", looks / 10.0, " s");
  int named = 0;
  testbed.next(*monitor);
  CHECK(testbed.wrong_ids(*monitor, &named) == 0);
  CHECK(named == 8);
  CHECK(monitor->doubtful().empty());

  const auto truth = testbed.emulator().truth();
  const hal::RobotId one = truth[1].id, other = truth[4].id;
  REQUIRE(testbed.emulator().command("swap 1 4 1.5") == "ok");
  bool both_doubted = false;
  int doubted_for = 0;
  for (looks = 0; looks < 215; ++looks) {
    testbed.next(*monitor);
    CHECK(testbed.wrong_ids(*monitor) == 0);
    const auto doubtful = monitor->doubtful();
    const auto doubted = [&](hal::RobotId id) { return std::binary_search(doubtful.begin(), doubtful.end(), id); };
    both_doubted = both_doubted || (doubted(one) && doubted(other));
    if (!doubtful.empty()) doubted_for = looks;
    // Only they are in doubt.
    for (const hal::RobotId id : doubtful) CHECK((id == one || id == other));
  }
  CHECK(both_doubted);
  CHECK(monitor->everybody_named());
  MESSAGE("both named again ", doubted_for / 10.0 - 1.5, " s after they were uncovered");
}

TEST_CASE("a monitor's configuration is refused with file, key and reason") {
  // Proves one sentence for each wrong camera testbed.
  const std::string head = "[arena]\nwidth_m = 0.5\nheight_m = 0.4\nrobots = 2\n";
  CHECK(contains(refusal(head), "cameras"));
  CHECK(contains(refusal(head + "[[arena.kilobot.cameras]]\nsource = \"0\"\n"), "calibration"));
  CHECK(contains(refusal(head + "[[arena.kilobot.cameras]]\nsource = \"clip.mp4\"\ncalibration = \"x.yaml\"\n"),
                 "is not a camera"));
  CHECK(contains(refusal(head + "[[arena.kilobot.cameras]]\nsource = \"0\"\ncalibration = \"none.yaml\"\n"),
                 "no such calibration"));
  CHECK(contains(refusal(head + "[arena.kilobot]\nidentity = \"guess\"\n"), "identity"));
}

TEST_CASE("a testbed's controller that is not there is refused with file, key and reason") {
  // Proves that a port that cannot be opened is told with the line that names it, cameras or not.
  const auto config = hal::Config::from_text(
      "[arena]\nrobots = 2\n[arena.kilobot]\nport = \"/dev/ttyNONE7\"\n"
      "[[arena.kilobot.cameras]]\nsource = \"/dev/video97\"\ncalibration = \"" ARKMESH_SOURCE_DIR
      "/experiments/emulator/roark_calibration.yaml\"\n",
      "lab.toml");
  std::string said;
  try {
    testbed::kilobot_arena_row().make(config.root().section("arena"), {.lab = "lab"});
  } catch (const hal::ConfigError& error) {
    said = error.what();
  }
  CHECK(contains(said, "lab.toml:4: arena.kilobot.port = \"/dev/ttyNONE7\": there is no serial port"));
}
