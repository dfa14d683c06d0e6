#include "testbed/arena_monitor.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "hal/arenas/newest_frame.hpp"
#include "hal/config/without_secrets.hpp"
#include "hal/platforms/kilobot/message_registers.hpp"
#include "testbed/placed_camera.hpp"
#include "tracker/camera/hung_camera.hpp"
#include "tracker/camera/source.hpp"

namespace arkmesh::testbed {
namespace {

struct Eye {
  std::string source;
  std::unique_ptr<tracker::CameraFeed> feed;
  tracker::HungCamera still;
  hal::LabTime latency{0};  // from light to the time of a picture
  std::string error;        // as last said
  bool hung = false;        // as last said
  bool other_size = false;  // its pictures are not of the calibration's size
  hal::LabTime taken{0};    // when the last picture was, by the time of looks
};

// What is known of where a camera should hang, and the command that finds it out anew.
struct Place {
  std::span<const tracker::Landmark> landmarks;
  std::string remedy;
};

constexpr hal::LabTime doubt_after{200'000};  // without any picture: robots may have been moved

class ArenaMonitor final : public hal::kilobot::RobotMonitor {
 public:
  ArenaMonitor(std::vector<Eye> eyes, std::vector<tracker::Calibration> calibrations, std::span<const Place> places,
               const tracker::ArenaTrackerSettings& settings, std::unique_ptr<tracker::NameKeeper> names,
               std::vector<hal::RobotId> expected, Observer observer)
      : eyes_(std::move(eyes)),
        arrived_(eyes_.size()),
        tracker_(std::move(calibrations), settings),
        names_(std::move(names)),
        observer_(std::move(observer)),
        poses_(own_counters_),
        expected_(std::move(expected)),
        doubtful_(expected_) {
    for (std::size_t i = 0; i < places.size(); ++i)
      placed_.emplace_back(i, eyes_[i].source, places[i].remedy, places[i].landmarks, tracker_, own_counters_);
  }

  void look(hal::LabTime now) override {
    std::vector<cv::Mat> pictures;
    no_use_ = false;
    for (std::size_t i = 0; i < eyes_.size(); ++i) pictures.push_back(newest(i, now));
    for (std::size_t i = 0; i < eyes_.size(); ++i)
      if (!pictures[i].empty() && !placed_[i].in_place(pictures[i], tracker_, own_counters_)) {
        no_use_ = true;
        pictures[i].release();
      }
    if (std::all_of(pictures.begin(), pictures.end(), [](const cv::Mat& picture) { return picture.empty(); })) {
      own_counters_.add("frame.no_picture");
      // one that is no use tells more than none at all
      if (no_use_ || now - seen_at_ >= doubt_after) doubtful_ = expected_;
      if (observer_) observer_({now, pictures, arrived_, tracker_, own_counters_});
      return;
    }
    seen_at_ = now;
    taken_ = std::max(taken_, taken(pictures));
    const std::vector<tracker::Track>& tracks = tracker_.look(taken_, pictures);
    for (std::size_t i = 0; i < eyes_.size(); ++i) placed_[i].learn(pictures[i], tracker_, own_counters_);
    names_->on_frame(now, tracks);
    for (const tracker::Naming& naming : names_->take_namings()) tracker_.associator().name(naming.track, naming.robot);
    update_doubtful(std::ranges::none_of(pictures, &cv::Mat::empty));
    poses_.put(frame(now));
    if (observer_) observer_({now, pictures, arrived_, tracker_, own_counters_});
  }

  void robots_run(bool run) override { robots_run_ = run; }
  std::optional<hal::PoseFrame> latest() override { return poses_.latest(); }
  std::optional<hal::kilobot::Message> question() const override {
    const std::optional<tracker::Question> asked = names_->question();
    if (!asked) return {};
    return hal::kilobot::fleet_message(
        {.kind = hal::FleetCommand::Kind::broadcast, .type = asked->type, .data = asked->data});
  }
  std::span<const hal::RobotId> doubtful() const override { return doubtful_; }
  bool everybody_named() const override { return names_->everybody_named(); }
  std::string error() const override {
    for (const Eye& eye : eyes_)
      if (eye.other_size) return eye.error;
    const auto troubled = std::ranges::find_if(placed_, [](const auto& camera) { return !camera.error().empty(); });
    return troubled == placed_.end() ? std::string() : troubled->error();
  }

  const hal::Counters& counters() const override {
    counters_ = own_counters_;
    counters_.merge(tracker_.counters());
    counters_.merge(names_->counters());
    for (const Eye& eye : eyes_) counters_.merge(eye.feed->counters());
    return counters_;
  }

 private:
  // When these were: each has its own time; in between for cameras that take turns.
  hal::LabTime taken(std::span<const cv::Mat> pictures) const {
    hal::LabTime sum{0};
    int given = 0;
    for (std::size_t i = 0; i < eyes_.size(); ++i)
      if (!pictures[i].empty()) sum += eyes_[i].taken, ++given;
    return sum / given;
  }

  // Empty: nothing new, or nothing that can be believed to be new.
  cv::Mat newest(std::size_t number, hal::LabTime now) {
    Eye& eye = eyes_[number];
    cv::Mat picture = eye.feed->newest();
    const hal::LabTime arrived = now - eye.feed->arrival().age, taken = arrived - eye.latency;
    const tracker::Lens& lens = tracker_.calibration(number)->data().lens;
    const bool other_size = !picture.empty() && (picture.cols != lens.width_px || picture.rows != lens.height_px);
    if (!picture.empty()) eye.other_size = other_size;
    for (std::string& fault : eye.feed->faults()) {
      if (fault == eye.error) continue;
      spdlog::warn("{}", fault);
      eye.error = std::move(fault);
    }
    std::string error = eye.feed->error();
    if (error.empty() && eye.other_size)
      error = other_size
                  ? fmt::format(
                        "the camera {} sends pictures of {} x {} pixels, and its calibration is for {} x {}: they "
                        "are not used; calibrate it at this resolution",
                        eye.source, picture.cols, picture.rows, lens.width_px, lens.height_px)
                  : eye.error;
    if (error != eye.error) {
      if (error.empty())
        spdlog::info("the camera {} gives pictures", eye.source);
      else
        spdlog::warn("{}", error);
      eye.error = std::move(error);
    }
    if (picture.empty()) return picture;
    if (other_size) {
      own_counters_.add("camera.refused.size");
      no_use_ = true;
      return {};
    }
    eye.taken = std::max(eye.taken, taken);
    arrived_[number] = arrived;
    using Verdict = tracker::HungCamera::Verdict;
    const Verdict verdict = eye.still.look(eye.taken, picture, robots_run_ || names_->question());
    if (verdict != Verdict::changed) own_counters_.add("camera.same_picture");
    if (verdict != Verdict::hung) {
      if (std::exchange(eye.hung, false)) spdlog::info("the pictures of the camera {} change again", eye.source);
      return picture;
    }
    if (!std::exchange(eye.hung, true))
      spdlog::warn(
          "the camera {} repeats one picture: does it hang, or does no robot move? Its pictures are not used until one "
          "differs",
          eye.source);
    own_counters_.add("camera.frozen");
    no_use_ = true;
    return {};
  }

  // Whoever is not in sight may be in somebody's hand: nothing is said to it from the first picture on that does not
  // show it. A camera that gave nothing new is no such picture.
  void update_doubtful(bool all_cameras) {
    const std::span<const hal::RobotId> nameless = names_->doubtful();
    doubtful_.assign(nameless.begin(), nameless.end());
    for (const tracker::Track& track : tracker_.tracks()) {
      if (track.age <= (all_cameras ? hal::LabTime{0} : doubt_after) && !track.doubtful) continue;
      if (const auto robot = names_->robot_of(track.number)) doubtful_.push_back(*robot);
    }
    std::ranges::sort(doubtful_);
    doubtful_.erase(std::unique(doubtful_.begin(), doubtful_.end()), doubtful_.end());
  }

  // Robots whose name is sure. Those out of sight are in it for as long as their name stays sure, with their age.
  hal::PoseFrame frame(hal::LabTime now) {
    hal::PoseFrame frame{.stamp = now, .number = number_++};
    std::map<tracker::TrackNumber, hal::Led> leds;
    for (const tracker::Track& track : tracker_.tracks()) {
      // An LED that answers a question says nothing of the robot's program.
      hal::Led led = track.led;
      if (names_->led_is_answer(track.number)) {
        const auto before = leds_.find(track.number);
        led = before == leds_.end() ? hal::Led::off : before->second;
      }
      leds.emplace(track.number, led);
      const auto robot = names_->robot_of(track.number);
      if (robot && !track.doubtful)
        frame.robots.push_back(
            {*robot, track.in_arena, led, track.confidence, track.age + (now - taken_), track.heading_noise_rad});
    }
    leds_ = std::move(leds);
    std::sort(frame.robots.begin(), frame.robots.end(), [](const auto& a, const auto& b) { return a.robot < b.robot; });
    return frame;
  }

  std::vector<Eye> eyes_;
  std::vector<hal::LabTime> arrived_;  // see Look
  tracker::ArenaTracker tracker_;
  std::unique_ptr<tracker::NameKeeper> names_;
  Observer observer_;
  hal::Counters own_counters_;
  std::vector<PlacedCamera> placed_;
  mutable hal::Counters counters_;
  hal::NewestFrame poses_;
  std::uint32_t number_ = 0;
  bool robots_run_ = false;  // as the arena says
  bool no_use_ = false;      // a camera gave a picture that shows nothing of now, or from elsewhere
  hal::LabTime seen_at_{0};  // when any camera last gave a picture
  hal::LabTime taken_{0};    // when those of the last look were taken
  std::vector<hal::RobotId> expected_, doubtful_;
  std::map<tracker::TrackNumber, hal::Led> leds_;  // what the programs show
};

}  // namespace

std::unique_ptr<hal::kilobot::RobotMonitor> make_arena_monitor(const KilobotSettings& settings, Observer observer,
                                                               const tracker::OpenCamera& open,
                                                               std::unique_ptr<tracker::NameKeeper> names) {
  std::vector<Eye> eyes;
  std::vector<Place> places;
  for (std::size_t i = 0; i < settings.cameras.size(); ++i) {
    const std::string& source = settings.cameras[i].source;
    const tracker::Lens& lens = settings.calibrations[i].data().lens;
    eyes.push_back({.source = hal::without_secrets(source),
                    .feed = open({source, lens.width_px, lens.height_px, settings.cameras[i].controls}),
                    .still = {},
                    .latency = hal::LabTime(std::llround(1000 * settings.cameras[i].latency_ms)),
                    .error = {}});
    const std::string& name = settings.cameras[i].name;
    places.push_back({settings.landmarks[i],
                      fmt::format("arkmesh calibrate ... {}--out {}", name.empty() ? "" : "--name " + name + " ",
                                  settings.cameras[i].calibration.string())});
  }
  const std::vector<hal::RobotId>& expected = settings.arena.info.robots;
  if (!names) names = settings.known_to_ark ? tracker::make_ark_names(expected) : tracker::make_spelled_names(expected);
  return std::make_unique<ArenaMonitor>(std::move(eyes), settings.calibrations, places, settings.tracking,
                                        std::move(names), expected, std::move(observer));
}

}  // namespace arkmesh::testbed
