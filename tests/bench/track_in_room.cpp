// How well robots are followed: renders a virtual room frame by frame, tracks it as a lab would, and compares with the truth.
// track_in_room ROOM.toml [SECONDS]. The robots are named from the truth at the beginning and two seconds after each doubt, as an
// identifier would; "wrong ids" are robot-frames in which a sure name was another robot's.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <vector>

#include "hal/config.hpp"
#include "sim_ode/room/room.hpp"
#include "tracker/table_tracker.hpp"

namespace {

using namespace arkmesh;

tracker::Calibration calibration_of(const sim_ode::room::CameraModel& model, double width_m, double height_m) {
  tracker::CameraData data;
  data.lens.width_px = model.width_px();
  data.lens.height_px = model.height_px();
  for (int i = 0; i < 9; ++i) data.lens.matrix[i] = model.matrix().val[i], data.rotation[i] = model.rotation().val[i];
  data.lens.distortion.assign(model.distortion().begin(), model.distortion().end());
  for (int i = 0; i < 3; ++i) data.translation_m[i] = model.translation()[i];
  data.arena_width_m = width_m;
  data.arena_height_m = height_m;
  return tracker::Calibration(std::move(data));
}

struct Score {
  std::uint64_t robot_frames = 0, tracked = 0, wrong = 0, strangers = 0, namings = 0, seen = 0, headings = 0, lit = 0, right_led = 0;
  double square_m = 0, square_rad = 0, off_x = 0, off_y = 0;
};

double apart_m(const hal::Pose& a, const hal::Pose& b) { return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m); }

void compare(const std::vector<sim_ode::room::Room::Truth>& truth, tracker::TableTracker& table, double now_s,
             std::map<tracker::TrackNumber, double>& nameless_since, Score& score) {
  const std::vector<tracker::Track> tracks = table.tracks();
  score.robot_frames += truth.size();
  for (const tracker::Track& track : tracks) {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < truth.size(); ++i)
      if (apart_m(truth[i].seen.pose, track.in_arena) < apart_m(truth[nearest].seen.pose, track.in_arena)) nearest = i;
    const hal::Pose& pose = truth[nearest].seen.pose;
    const double off_m = apart_m(pose, track.in_arena);
    const auto id = static_cast<hal::RobotId>(nearest);
    if (off_m > 0.0165 && track.age.count() == 0) ++score.strangers;
    if (track.robot && !track.doubtful && apart_m(truth[*track.robot].seen.pose, track.in_arena) > 0.02) ++score.wrong;
    if (track.robot == id && off_m < 0.0165) {
      ++score.tracked;
      if (track.age.count() == 0) {
        ++score.seen;
        score.square_m += off_m * off_m;
        score.off_x += track.in_arena.x_m - pose.x_m;
        score.off_y += track.in_arena.y_m - pose.y_m;
        if (track.led_seen && track.led != hal::Led::off && truth[nearest].led != hal::Led::off) {
          const double off_rad = tracker::wrapped(track.in_arena.heading_rad - pose.heading_rad);
          score.square_rad += off_rad * off_rad;
          ++score.headings;
        }
        if (track.led_seen) ++score.lit, score.right_led += track.led == truth[nearest].led;
      }
    }
    if (track.robot && !track.doubtful) {
      nameless_since.erase(track.number);
    } else if (track.age.count() == 0 && off_m < 0.0165) {
      const double since = nameless_since.try_emplace(track.number, now_s).first->second;
      if (now_s > 0 && now_s - since < 2) continue;
      table.associator().name(track.number, id);
      ++score.namings;
    }
  }
}

int measure(const char* file, double seconds) {
  const hal::Config config = hal::Config::from_file(file);
  sim_ode::room::Room room(config.root());
  const hal::Section arena = config.root().section("arena");
  const double width_m = arena.number("width_m", 1), height_m = arena.number("height_m", 1);
  tracker::TableSettings settings;
  settings.expected_robots = static_cast<std::size_t>(room.robots());
  std::vector<tracker::Calibration> cameras;
  for (std::size_t k = 0; k < room.cameras(); ++k) cameras.push_back(calibration_of(room.camera(k).model_at_first(), width_m, height_m));
  tracker::TableTracker table(std::move(cameras), settings);

  Score score;
  std::map<tracker::TrackNumber, double> nameless_since;
  std::vector<cv::Mat> pictures(room.cameras());
  double tracking_s = 0;
  const hal::LabTime period = room.config().frame_period;
  std::int64_t frame = 0;
  // The overhead controller needs two seconds to start; then the robots run.
  room.advance_to(hal::LabTime(3'000'000));
  room.command("say run");
  const hal::LabTime begun = room.now();
  for (; static_cast<double>((frame * period).count()) * 1e-6 < seconds; ++frame) {
    room.advance_to(begun + frame * period);
    for (std::size_t k = 0; k < room.cameras(); ++k)
      if (!room.picture(k, pictures[k])) pictures[k].release();
    const auto before = std::chrono::steady_clock::now();
    table.look(room.now(), pictures);
    tracking_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    // Names are given at once; then everybody counts.
    if (Score none; frame == 0) compare(room.truth(), table, 0, nameless_since, none);
    score.namings += frame == 0 ? table.tracks().size() : 0;
    compare(room.truth(), table, static_cast<double>((frame * period).count()) * 1e-6, nameless_since, score);
  }
  const double n = static_cast<double>(score.seen), all = static_cast<double>(score.robot_frames);
  fmt::print("{} robots, {} frames ({:.0f} s), {} camera(s)\n", room.robots(), frame, seconds, room.cameras());
  fmt::print("  tracked               {:.3f} % of robot-frames\n", 100 * static_cast<double>(score.tracked) / all);
  fmt::print("  wrong ids             {} robot-frames\n", score.wrong);
  fmt::print("  strangers             {} track-frames with no robot there\n", score.strangers);
  fmt::print("  named                 {} times\n", score.namings);
  fmt::print("  centre RMS            {:.3f} mm (mean {:.3f}, {:.3f})\n", 1000 * std::sqrt(score.square_m / n), 1000 * score.off_x / n,
             1000 * score.off_y / n);
  fmt::print("  heading RMS, LED on   {:.2f} degrees ({} looks)\n",
             std::sqrt(score.square_rad / static_cast<double>(score.headings)) * 180 / std::numbers::pi, score.headings);
  fmt::print("  LED colour right      {:.2f} % of those seen\n",
      100 * static_cast<double>(score.right_led) / static_cast<double>(score.lit));
  fmt::print("  tracking              {:.2f} ms a frame\n", 1000 * tracking_s / static_cast<double>(frame));
  for (const auto& [name, total] : table.counters().all()) fmt::print("  {:<21} {}\n", name, total);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "track_in_room ROOM.toml [SECONDS]\n");
    return 2;
  }
  try {
    return measure(argv[1], argc > 2 ? std::atof(argv[2]) : 60);
  } catch (const std::exception& error) {
    fmt::print(stderr, "track_in_room: {}\n", error.what());
    return 1;
  }
}
