#include "emulator/emulated_arena.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

#include "hal/arenas/fault_port.hpp"
#include "hal/platforms/kilobot/kilobot_arena.hpp"
#include "hal/time/wall_time.hpp"
#include "sim_ode/host/programs/robot_program.hpp"
#include "sim_ode/ode_arena.hpp"
#include "testbed/arena_video.hpp"
#include "testbed/kilobot_settings.hpp"
#include "testbed/recorded_devices.hpp"
#include "testbed/tracks.hpp"

namespace arkmesh::emulator {
namespace {

using emulator::Emulator;
using hal::kilobot::ByteStream;

// The pictures of each camera of an emulator that have not arrived, and the newest that has.
class EmulatedCameras {
 public:
  explicit EmulatedCameras(Emulator& emulator)
      : emulator_(emulator), pictures_(emulator.cameras()), gone_(emulator.cameras(), false) {}

  struct Arrived {
    cv::Mat bgr;          // empty: none
    hal::LabTime age{0};  // of a camera without latency 0: its pictures are those of the look
  };

  void look() {
    for (std::size_t k = 0; k < pictures_.size(); ++k) {
      cv::Mat picture;
      gone_[k] = !emulator_.picture(k, picture);
      if (gone_[k]) pictures_[k].clear();
      if (gone_[k]) continue;
      pictures_[k].push_back({std::move(picture), emulator_.now() + emulator_.camera(k).settings().latency});
      drop_old(k);
    }
  }
  Arrived take(std::size_t camera) {
    drop_old(camera);
    std::deque<Picture>& all = pictures_[camera];
    if (all.empty() || all.front().arrives > emulator_.now()) return {};
    const bool late = emulator_.camera(camera).settings().latency.count() > 0;
    const Arrived out{all.front().bgr, late ? emulator_.now() - all.front().arrives : hal::LabTime{0}};
    all.pop_front();
    return out;
  }
  bool is_gone(std::size_t camera) const { return gone_[camera]; }

 private:
  struct Picture {
    cv::Mat bgr;
    hal::LabTime arrives;
  };
  void drop_old(std::size_t camera) {
    std::deque<Picture>& all = pictures_[camera];
    while (all.size() > 1 && all[1].arrives <= emulator_.now()) all.pop_front();
  }

  Emulator& emulator_;
  std::vector<std::deque<Picture>> pictures_;
  std::vector<bool> gone_;
};

class EmulatedFeed final : public tracker::CameraFeed {
 public:
  EmulatedFeed(EmulatedCameras& eyes, std::size_t camera, std::string name)
      : eyes_(eyes), camera_(camera), name_(std::move(name)) {}
  cv::Mat newest() override {
    const bool gone = eyes_.is_gone(camera_);
    if (gone && !was_gone_) counters_.add("camera.gone");
    was_gone_ = gone;
    EmulatedCameras::Arrived arrived = eyes_.take(camera_);
    if (!arrived.bgr.empty()) age_ = arrived.age;
    return std::move(arrived.bgr);
  }
  tracker::Arrival arrival() const override { return {.age = age_, .jpeg = {}}; }
  std::string error() const override {
    return eyes_.is_gone(camera_) ? fmt::format("the emulator's camera {} gives no pictures", name_) : "";
  }
  hal::Counters counters() const override { return counters_; }

 private:
  EmulatedCameras& eyes_;
  std::size_t camera_;
  std::string name_;
  hal::LabTime age_{0};
  bool was_gone_ = false;
  hal::Counters counters_;
};

class EmulatedStream final : public ByteStream {
 public:
  explicit EmulatedStream(Emulator& emulator) : emulator_(emulator) {}
  void open() override { open_ = emulator_.ohc_plugged(); }
  State check() override {
    open_ = open_ && emulator_.ohc_plugged();
    error_ = open_ ? "" : "the emulator's overhead controller is unplugged";
    return open_ ? State::open : State::closed;
  }
  std::size_t write(std::span<const std::uint8_t> bytes) override {
    if (check() != State::open) return 0;
    const std::size_t fits = std::min(bytes.size(), emulator_.serial_free());
    emulator_.write_serial(bytes.first(fits));
    return fits;
  }
  std::size_t waiting_bytes() override { return emulator::OhcSerialPort::max_waiting - emulator_.serial_free(); }
  const std::string& error() const override { return error_; }

 private:
  Emulator& emulator_;
  bool open_ = false;
  std::string error_;
};

// Waiting is what lets the emulator's time pass. Cameras take their pictures at whole frame periods; of several in one
// wait the last.
class EmulatedTime final : public hal::WallTime {
 public:
  EmulatedTime(Emulator& emulator, EmulatedCameras& eyes) : emulator_(emulator), eyes_(eyes) {}
  hal::TimePoint now() override { return hal::TimePoint{} + emulator_.now(); }
  void wait_until(hal::TimePoint then) override {
    // Devices wait for moments finer than the emulator's microseconds: never less than asked, and never nothing.
    const auto end = std::chrono::ceil<hal::LabTime>(then.time_since_epoch());
    const hal::LabTime period = emulator_.config().frame_period, last = period * (end / period);
    if (last > pictured_) {
      emulator_.advance_to(std::max(emulator_.now(), last));
      eyes_.look();
      pictured_ = last;
    }
    if (end > emulator_.now()) emulator_.advance_to(end);
  }

 private:
  Emulator& emulator_;
  EmulatedCameras& eyes_;
  hal::LabTime pictured_{-1};
};

class EmulatedArena final : public hal::Arena, public hal::FaultPort {
 public:
  // `names` finds out who is who, in place of what the settings say. Without an observer people may watch.
  EmulatedArena(hal::Config config, const hal::Section& arena, const hal::ArenaRequest& request,
                testbed::Observer observer, std::unique_ptr<tracker::NameKeeper> names)
      : config_(std::move(config)), emulator_(config_.root()), eyes_(emulator_), time_(emulator_, eyes_) {
    if (emulator_.nodes())
      config_.root().section("arena").section("ode").refuse(
          "robot",
          "must be \"kilobot\" for arena.use = \"emulated\"; for other robots start `arkmesh emulator`, and set "
          "arena.use = \"aseba\"");
    config_.refuse_unknown();
    const testbed::KilobotSettings settings = testbed::read_kilobot_settings(arena, request.lab, emulator_.cameras());
    if (!observer) observer = testbed::make_viewers(settings, request);
    const auto record = testbed::make_record(arena.section("kilobot"), settings, request.lab, "emulated", false, time_);
    const auto open = [this, next = std::size_t{0}](const tracker::CameraRequest&) mutable {
      const std::size_t camera = next++;
      return std::make_unique<EmulatedFeed>(eyes_, camera, emulator_.camera(camera).settings().name);
    };
    auto eyes = testbed::make_arena_monitor(settings, testbed::recorded(std::move(observer), record),
                                            testbed::recorded(open, record), std::move(names));
    auto stream = testbed::recorded(std::make_unique<EmulatedStream>(emulator_), record);
    arena_ = testbed::recorded(
        hal::kilobot::make_kilobot_arena(settings.arena, std::move(eyes), std::move(stream), nullptr, time_), record);
  }

  const hal::ArenaInfo& info() const override { return arena_->info(); }
  const hal::Clock& clock() const override { return arena_->clock(); }
  hal::PoseSource& poses() override { return arena_->poses(); }
  hal::RobotLink& robots() override { return arena_->robots(); }
  bool advance_to(hal::LabTime t) override { return is_there(arena_->advance_to(t)); }
  // Devices are served at each moment of the emulator's time, and between calls of advance_to none passes.
  void serve() override {}
  hal::TimePoint next_service() const override { return wanted_ ? hal::TimePoint::min() : hal::TimePoint::max(); }
  std::string waiting_for() const override { return arena_->waiting_for(); }
  bool end() override { return is_there(arena_->end()); }
  std::vector<hal::NotStanding> not_standing() const override { return arena_->not_standing(); }
  const hal::Counters& counters() const override { return arena_->counters(); }
  Emulator& emulator() { return emulator_; }

  std::string fault(std::string_view line) override { return emulator_.command(line); }

 private:
  // Nobody waits here: whoever calls again finds the emulator at the moment that the arena wanted.
  bool is_there(bool there) {
    wanted_ = !there;
    if (wanted_) time_.wait_until(arena_->next_service());
    return there;
  }

  hal::Config config_;
  Emulator emulator_;
  EmulatedCameras eyes_;
  EmulatedTime time_;
  std::unique_ptr<hal::Arena> arena_;
  bool wanted_ = false;  // the last call was answered with false
};

std::unique_ptr<EmulatedArena> make(const hal::Section& arena, const hal::ArenaRequest& request,
                                    testbed::Observer observer, std::unique_ptr<tracker::NameKeeper> names) {
  const std::filesystem::path file = arena.section("emulated").read<EmulatedConfig>().file;
  std::vector<std::string> sets{fmt::format("emulator.seed={}", request.seed)};
  if (!request.program.empty())
    sets.insert(sets.end(), {"arena.ode.controller=" + (sim_ode::firmware_folder() / request.program).string(),
                             "arena.ode.group=[]"});
  return std::make_unique<EmulatedArena>(hal::Config::from_file(file, sets), arena, request, std::move(observer),
                                         std::move(names));
}

}  // namespace

std::unique_ptr<hal::Arena> make_emulated_arena(const hal::Section& arena, const std::string& lab, std::uint64_t seed,
                                                testbed::Observer observer) {
  return make(arena, {.lab = lab, .seed = seed}, std::move(observer), nullptr);
}

hal::ArenaRow emulated_arena_row() {
  return {"emulated",
          {"emulated", "kilobot"},
          hal::ArenaRow::Robots::simulated,
          [](const hal::Section& arena, const hal::ArenaRequest& request) -> std::unique_ptr<hal::Arena> {
            if (!request.set_up) return make(arena, request, {}, nullptr);
            auto names = std::make_unique<testbed::UnnamedTracks>();
            testbed::UnnamedTracks& tracks = *names;
            return testbed::with_tracks(make(arena, request, tracks.observer({}), std::move(names)), tracks);
          },
          [] {
            std::vector<hal::KeyRow> rows = hal::keys_of<EmulatedConfig>("arena.emulated");
            std::ranges::move(hal::keys_of<EmulatorConfig>("emulator"), std::back_inserter(rows));
            return rows;
          },
          hal::kilobot::message_period,
          [](const hal::Section& arena) {
            const auto file = arena.section("emulated").read<EmulatedConfig>().file;
            return sim_ode::program_files(hal::Config::from_file(file).root().section("arena"));
          }};
}

emulator::Emulator& emulator_of(hal::Arena& arena) {
  auto* const own = dynamic_cast<EmulatedArena*>(&arena);
  if (!own) throw std::logic_error("emulator_of: this arena is no emulated testbed");
  return own->emulator();
}

}  // namespace arkmesh::emulator
