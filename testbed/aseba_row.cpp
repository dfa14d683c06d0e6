#include "testbed/aseba_row.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include "hal/arenas/arena_config.hpp"
#include "hal/arenas/newest_frame.hpp"
#include "hal/arenas/robot_words.hpp"
#include "hal/config/without_secrets.hpp"
#include "hal/platforms/aseba/aseba_arena.hpp"
#include "hal/platforms/aseba/aseba_link.hpp"
#include "testbed/devices.hpp"
#include "testbed/kilobot_settings.hpp"
#include "tracker/camera/live_camera.hpp"
#include "tracker/follow/marker_tracker.hpp"

namespace arkmesh::testbed {
namespace {

// Of [arena.aseba], beside what the arena reads.
struct MarkerKeys {
  tracker::MarkerSettings markers;
  double turned_deg = 0;
  double height_m = std::numeric_limits<double>::quiet_NaN();  // the robot's
  std::vector<CameraSettings> cameras;

  void fields(const hal::Section& aseba) {
    aseba.field("markers", markers.family,
                {.help = "family of the robots' markers; marker numbers are robot ids",
                 .one_of = tracker::MarkerFinder::families()});
    aseba.field("marker_m", markers.side_m, {{0.005, 1}, "m", "side of a marker's black square"});
    aseba.field("marker_height_m", height_m,
                {.range = {0, 1},
                 .unit = "m",
                 .help = "height of the markers above the arena",
                 .default_is = "the robot's height"});
    aseba.field("marker_turned_deg", turned_deg,
                {{-180, 180}, "deg", "driving direction minus the direction of the printed top, counter-clockwise"});
    aseba.field("cameras", cameras);
  }
};

struct AsebaTestbed {
  hal::aseba::AsebaSettings arena;
  MarkerKeys keys;
  std::vector<tracker::Calibration> calibrations;
};

AsebaTestbed read_testbed(const hal::Section& arena, const std::string& lab) {
  const hal::Section aseba = arena.section("aseba");
  AsebaTestbed out{hal::aseba::read_aseba_settings(arena, lab), aseba.read<MarkerKeys>(), {}};
  tracker::MarkerSettings& markers = out.keys.markers;
  markers.robots = out.arena.info.robots;
  markers.height_m = std::isnan(out.keys.height_m) ? hal::aseba::kind_of(out.arena.make).height_m : out.keys.height_m;
  markers.turned_rad = out.keys.turned_deg * std::numbers::pi / 180;
  markers.top_speed_m_s = out.arena.info.drive.speed_m_s;
  if (static_cast<int>(markers.robots.back()) >= tracker::MarkerFinder::numbers(markers.family))
    aseba.refuse("markers", fmt::format("has the numbers 0 to {}, but robot {} has none of them",
                                        tracker::MarkerFinder::numbers(markers.family) - 1, markers.robots.back()));
  const std::size_t cameras = out.keys.cameras.size();
  if (cameras == 0)
    aseba.refuse("cameras", "give one to four cameras, each as [[arena.aseba.cameras]] with source and calibration");
  if (cameras > 4) aseba.refuse("cameras", fmt::format("there are {} cameras; at most four can be used", cameras));
  const hal::ArenaConfig config = hal::read_arena_config(arena, out.arena.info.body_radius_m);
  for (std::size_t i = 0; i < cameras; ++i)
    out.calibrations.emplace_back(
        placed_calibration(aseba.section("cameras", static_cast<int>(i)), out.keys.cameras[i], i, cameras, config)
            .data);
  return out;
}

class MarkerEyes final : public hal::aseba::Eyes {
 public:
  explicit MarkerEyes(const AsebaTestbed& testbed)
      : cameras_(testbed.keys.cameras), tracker_(testbed.calibrations, testbed.keys.markers) {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const tracker::Lens& lens = testbed.calibrations[i].data().lens;
      feeds_.push_back(tracker::open_camera({cameras_[i].source, lens.width_px, lens.height_px, cameras_[i].controls}));
    }
  }

  void look(hal::LabTime now) override {
    std::vector<cv::Mat> pictures;
    hal::LabTime age{0};
    error_.clear();
    for (std::size_t i = 0; i < feeds_.size(); ++i) {
      pictures.push_back(feeds_[i]->newest());
      const tracker::Lens& lens = tracker_.calibration(i).data().lens;
      if (const std::string error = feeds_[i]->error(); !error.empty()) {
        error_ = error;
      } else if (!pictures[i].empty() && (pictures[i].cols != lens.width_px || pictures[i].rows != lens.height_px)) {
        error_ = fmt::format("the camera {} sends pictures of {} x {} pixels, and its calibration is for {} x {}",
                             hal::without_secrets(cameras_[i].source), pictures[i].cols, pictures[i].rows,
                             lens.width_px, lens.height_px);
        pictures[i].release();
        own_counters_.add("camera.refused.size");
      }
      if (!pictures[i].empty())
        age = std::max(age, feeds_[i]->arrival().age + hal::LabTime(std::llround(1000 * cameras_[i].latency_ms)));
    }
    if (error_ != said_) {
      if (error_.empty())
        spdlog::info("the cameras give pictures");
      else
        spdlog::warn("{}", error_);
      said_ = error_;
    }
    if (std::ranges::all_of(pictures, &cv::Mat::empty)) return own_counters_.add("frame.no_picture");
    hal::PoseFrame frame{.stamp = now, .number = number_++, .robots = tracker_.look(now, pictures), .objects = {}};
    for (hal::Observation& robot : frame.robots) robot.age = age;
    poses_.put(std::move(frame));
  }

  std::optional<hal::PoseFrame> latest() override { return poses_.latest(); }
  const std::vector<hal::RobotId>& missing() const override { return tracker_.missing(); }
  std::string error() const override { return error_; }
  const hal::Counters& counters() const override {
    counters_ = own_counters_;
    counters_.merge(tracker_.counters());
    for (const auto& feed : feeds_) counters_.merge(feed->counters());
    return counters_;
  }

 private:
  const std::vector<CameraSettings> cameras_;
  std::vector<std::unique_ptr<tracker::CameraFeed>> feeds_;
  tracker::MarkerTracker tracker_;
  hal::Counters own_counters_;
  mutable hal::Counters counters_;
  hal::NewestFrame poses_{own_counters_};
  std::uint32_t number_ = 0;
  std::string error_, said_;
};

std::unique_ptr<hal::Arena> make_aseba(const hal::Section& arena, const hal::ArenaRequest& request) {
  const hal::Section aseba = arena.section("aseba");
  if (request.set_up)
    arena.refuse(
        "use", "has robots that are named by their markers, so there is nothing to set up; arkmesh doctor lists them");
  const AsebaTestbed testbed = read_testbed(arena, request.lab);
  return hal::aseba::make_aseba_arena(testbed.arena, hal::aseba::open_connections(aseba, testbed.arena),
                                      std::make_unique<MarkerEyes>(testbed));
}

}  // namespace

hal::ArenaRow aseba_arena_row() {
  return {"aseba", {"aseba"}, hal::ArenaRow::Robots::real, make_aseba, [] {
            std::vector<hal::KeyRow> rows = hal::keys_of<hal::aseba::AsebaSettings>("arena.aseba");
            std::ranges::move(hal::keys_of<MarkerKeys>("arena.aseba"), std::back_inserter(rows));
            return rows;
          }};
}

std::vector<hal::Finding> find_nodes(const hal::Section& arena) {
  using namespace std::chrono_literals;
  const hal::Section aseba = arena.section("aseba");
  const AsebaTestbed testbed = read_testbed(arena, "doctor");
  hal::Counters counters;
  hal::aseba::Nodes nodes(hal::aseba::open_connections(aseba, testbed.arena), testbed.arena.info.robots,
                          hal::aseba::make_of(testbed.arena.make), counters);
  hal::WallTime& wall = hal::machine_time();
  // a node may answer some seconds late
  std::set<hal::RobotId> guarded;
  hal::TimePoint ask_at{};
  for (const hal::TimePoint begin = wall.now(), end = begin + 8s; wall.now() < end;) {
    nodes.poll(wall.now());
    for (const auto& [robot, message] : nodes.take_events())
      if (message.type == hal::aseba::event_here) guarded.insert(robot);
    if (wall.now() > begin + 1500ms && nodes.missing().empty() && guarded.size() == testbed.arena.info.robots.size())
      break;
    if (wall.now() >= ask_at) {
      ask_at = wall.now() + 500ms;
      nodes.tell_all(hal::aseba::event_run, {hal::aseba::only_answer});
    }
    wall.wait_until(wall.now() + 10ms);
  }
  std::vector<hal::Finding> out;
  for (const std::string& robot : nodes.described()) out.push_back({robot, "", ""});
  if (const std::string missing = nodes.missing(); !missing.empty())
    out.push_back({"nodes of " + testbed.arena.connect, missing, "correct arena.aseba.connect, robot or first_id"});
  std::vector<hal::RobotId> unguarded;
  for (const hal::RobotId robot : testbed.arena.info.robots)
    if (nodes.is_here(robot) && !guarded.contains(robot)) unguarded.push_back(robot);
  if (!unguarded.empty())
    out.push_back({"programs of robots",
                   fmt::format("robots {} {}", hal::in_words(unguarded), hal::aseba::runs_no_guard),
                   "load robot.aesl into them (hal/platforms/aseba/README.md)"});
  for (std::size_t i = 0; i < testbed.keys.cameras.size(); ++i) {
    const CameraSettings& camera = testbed.keys.cameras[i];
    out.push_back(find_camera(camera, i, testbed.keys.cameras.size()));
    if (std::isnan(camera.controls.exposure_ms)) continue;
    const double fastest_m_s =
        tracker::MarkerTracker::largest_speed_m_s(testbed.keys.markers, camera.controls.exposure_ms / 1000);
    const double speed_m_s = testbed.arena.info.drive.speed_m_s;
    hal::Finding finding{fmt::format("markers of {:.0f} mm, exposed for {} ms: seen up to {:.2f} m/s",
                                     1000 * testbed.keys.markers.side_m, camera.controls.exposure_ms, fastest_m_s),
                         "", "use a shorter exposure and more light, or larger markers"};
    if (fastest_m_s < speed_m_s) finding.problem = fmt::format("robots drive up to {:.2f} m/s", speed_m_s);
    out.push_back(std::move(finding));
  }
  return out;
}

}  // namespace arkmesh::testbed
