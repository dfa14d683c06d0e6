// Reads the log twice: once to learn its robots, frames and length, then along with lab time. Holds one frame at a
// time, so memory does not grow with the log. Everything in a log is checked: it may come from anywhere.
#include "hal/arenas/log_arena.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cassert>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "hal/arenas/arena_config.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/arenas/newest_frame.hpp"
#include "hal/arenas/silent_link.hpp"
#include "hal/bus/bus.hpp"
#include "hal/layout/message.hpp"
#include "hal/record/event_log.hpp"

namespace arkmesh::hal {

namespace {

constexpr std::size_t max_robots = 100'000;
constexpr double max_place_m = 1000;  // no arena is so large; what computes in whole units cannot overflow

bool is_sane(const pose_frame_t& part) {
  for (const object_pose_t& pose : part.objects)
    if (!(std::abs(pose.x_m) <= max_place_m) || !(std::abs(pose.y_m) <= max_place_m) ||
        !(std::abs(pose.heading_rad) <= std::numbers::pi) || !(pose.confidence >= 0 && pose.confidence <= 1) ||
        pose.age_us < 0)
      return false;
  if (part.stamp_us < 0 || part.number < 0 || part.parts < 1 || part.part < 0 || part.part >= part.parts) return false;
  for (const robot_pose_t& pose : part.robots) {
    if (pose.robot < 0) return false;
    if (!(std::abs(pose.x_m) <= max_place_m) || !(std::abs(pose.y_m) <= max_place_m) ||
        !(std::abs(pose.heading_rad) <= std::numbers::pi))
      return false;
    if (pose.led > 8 || !(pose.confidence >= 0 && pose.confidence <= 1) || pose.age_us < 0) return false;
  }
  return true;
}

// Whether the stamp is number * period. Divides, for the product of a log's numbers may be anything.
bool is_even(const PoseFrame& frame, LabTime period) {
  if (frame.number == 0) return frame.stamp == LabTime{0};
  return frame.stamp % frame.number == LabTime{0} && frame.stamp / frame.number == period;
}

bool is_ascending(const std::vector<Observation>& robots) {
  for (std::size_t i = 1; i < robots.size(); ++i)
    if (robots[i].robot <= robots[i - 1].robot) return false;
  return true;
}

// The whole pose frames of a log, in order. Frames that are damaged, incomplete or out of order are left out and
// counted.
class FrameReader {
 public:
  FrameReader(const std::filesystem::path& file, Counters& counters) : log_(file), counters_(counters) {}

  // Nothing at the end of the log. `info` is filled when the log's `arena` message passes.
  std::optional<PoseFrame> next() {
    while (auto event = log_.next()) {
      if (event->channel == channel::arena) take_info(event->bytes);
      if (event->channel != channel::poses) continue;
      const std::span<const std::byte> bytes(event->bytes);
      const std::uint64_t type = layout::big_endian(bytes.first(std::min<std::size_t>(8, bytes.size())));
      if (type != layout::type_for<pose_frame_t>().fingerprint) other_type = type;
      if (auto frame = take_part(event->bytes)) return frame;
    }
    return {};
  }
  std::string left_out() const { return log_.truncated() ? log_.left_out() : ""; }

  std::optional<arena_info_t> info;
  std::uint64_t other_type = 0;  // of poses that another version of arkmesh wrote; 0: there are none

 private:
  void take_info(std::span<const std::byte> bytes) {
    arena_info_t message;
    if (!info && decode(bytes, message)) info = std::move(message);
  }

  std::optional<PoseFrame> take_part(std::span<const std::byte> bytes) {
    pose_frame_t message;
    if (!decode(bytes, message) || !is_sane(message)) return refuse("replay.refused.damaged");
    PoseFrame part = from_message(message);
    const bool first = message.part == 0;
    if (first && !building_.robots.empty() && next_part_ > 0) counters_.add("replay.refused.incomplete");
    if (first) {
      building_ = std::move(part);
      next_part_ = 0;
    } else if (message.part != next_part_ || part.number != building_.number || part.stamp != building_.stamp) {
      next_part_ = -1;
      return refuse("replay.refused.incomplete");
    } else {
      building_.robots.insert(building_.robots.end(), part.robots.begin(), part.robots.end());
    }
    if (building_.robots.size() > max_robots) {
      building_ = {};
      next_part_ = -1;
      return refuse("replay.refused.damaged");
    }
    if (++next_part_ < message.parts) return {};
    next_part_ = 0;

    // a whole frame
    PoseFrame frame = std::exchange(building_, {});
    if (!is_ascending(frame.robots)) return refuse("replay.refused.damaged");
    if (last_ && (frame.number <= last_->number || frame.stamp <= last_->stamp))
      return refuse("replay.refused.out_of_order");
    last_ = Last{frame.number, frame.stamp};
    return frame;
  }

  std::optional<PoseFrame> refuse(const char* why) {
    counters_.add(why);
    return {};
  }

  struct Last {
    std::uint32_t number;
    LabTime stamp;
  };
  EventLogReader log_;
  Counters& counters_;
  PoseFrame building_;  // the parts so far
  int next_part_ = 0;   // -1: none until a frame begins
  std::optional<Last> last_;
};

// What a first reading tells.
struct Survey {
  std::set<RobotId> robots;
  std::uint64_t frames = 0;
  std::uint32_t first_number = 0;
  LabTime first_stamp{0}, last_stamp{0}, frame_period{0};
  bool even = true;      // every frame is stamped number * frame_period
  std::string left_out;  // of a log that is cut or damaged, in words
  std::optional<arena_info_t> info;
  std::size_t objects = 0;   // in the first frame
  bool same_objects = true;  // in all others
  std::uint64_t other_type = 0;
};

Survey survey(const std::filesystem::path& file) {
  Survey out;
  Counters ignored;  // the second reading counts
  FrameReader reader(file, ignored);
  while (const auto frame = reader.next()) {
    if (out.frames++ == 0)
      out.first_number = frame->number, out.first_stamp = frame->stamp, out.objects = frame->objects.size();
    else if (out.frame_period == LabTime{0})
      out.frame_period = (frame->stamp - out.first_stamp) / (frame->number - out.first_number);
    out.even = out.even && is_even(*frame, out.frame_period);
    out.same_objects = out.same_objects && frame->objects.size() == out.objects;
    out.last_stamp = frame->stamp;
    for (const Observation& observation : frame->robots) out.robots.insert(observation.robot);
  }
  out.left_out = reader.left_out();
  out.info = reader.info;
  out.other_type = reader.other_type;
  return out;
}

class LogArena final : public Arena {
 public:
  // `last`: stamp of the log's last frame.
  LogArena(const std::filesystem::path& file, ArenaInfo info, LabTime last)
      : file_(file),
        info_(std::move(info)),
        poses_(counters_),
        link_(info_, counters_),
        reader_(file, counters_),
        last_(last) {
    ahead_ = reader_.next();
  }

  const ArenaInfo& info() const override { return info_; }
  const Clock& clock() const override { return clock_; }
  PoseSource& poses() override { return poses_; }
  RobotLink& robots() override { return link_; }
  const Counters& counters() const override { return counters_; }

  bool advance_to(LabTime t) override {
    assert(t >= clock_.now() && "lab time never decreases");
    while (ahead_ && ahead_->stamp <= t) {
      newest_ = ahead_->stamp;
      poses_.put(std::move(*ahead_));
      ahead_ = reader_.next();
    }
    if (!ahead_ && newest_ < last_ && newest_ < t)
      throw std::runtime_error(fmt::format("the log {} changed during the replay", file_.string()));
    clock_.set(t);
    return true;
  }
  void serve() override {}
  TimePoint next_service() const override { return TimePoint::max(); }
  std::string waiting_for() const override { return {}; }
  bool end() override { return true; }
  std::vector<NotStanding> not_standing() const override { return {}; }

 private:
  std::filesystem::path file_;
  Counters counters_;
  ArenaInfo info_;
  OwnedClock clock_;
  NewestFrame poses_;
  SilentLink link_;
  FrameReader reader_;
  std::optional<PoseFrame> ahead_;  // read, but its time has not come
  LabTime last_;                    // stamp of the log's last frame
  LabTime newest_{-1};              // stamp of the newest frame given out
};

struct ReplayConfig {
  std::filesystem::path log;

  void fields(const Section& replay) {
    replay.field("log", log,
                 {.help = "the LCM log whose poses are replayed", .sample = "\"log.lcm\"", .required = true});
  }
};

std::string seconds(LabTime t) {
  return fmt::format("{} s", std::chrono::duration<double>(t).count());
}

}  // namespace

ArenaRow log_arena_row() {
  return {"replay",
          {"replay"},
          ArenaRow::Robots::none,
          [](const Section& arena, const ArenaRequest& request) {
            return make_log_arena(arena, request.lab, request.robot, request.run_length);
          },
          [] { return keys_of<ReplayConfig>("arena.replay"); }};
}

std::unique_ptr<Arena> make_log_arena(const Section& arena, const std::string& lab, const RobotKind& robot,
                                      LabTime run_length) {
  const Section replay = arena.section("replay");
  const std::filesystem::path file = replay.read<ReplayConfig>().log;
  const auto refuse = [&](std::string_view sentence) { replay.refuse("log", sentence); };

  Survey found;
  try {
    found = survey(file);
  } catch (const std::runtime_error& error) {
    refuse(error.what());
  }
  if (!found.left_out.empty())
    spdlog::warn("the log {} is cut or damaged: {} skipped, and its poses are used up to {}", file.string(),
                 found.left_out, seconds(found.last_stamp));
  if (found.frames == 0 && found.other_type != 0)
    refuse(
        fmt::format("the log is from another version of arkmesh: its poses have type {:016x}, those of arkmesh {} type "
                    "{:016x}; replay it with the version that recorded it",
                    found.other_type, ARKMESH_VERSION, layout::type_for<pose_frame_t>().fingerprint));
  if (found.frames == 0) refuse("the log holds no poses");
  if (found.first_number != 0 || found.first_stamp != LabTime{0})
    refuse(fmt::format("the log begins with frame {} at {}, not with frame 0; record it from the beginning of a run",
                       found.first_number, seconds(found.first_stamp)));
  if (!found.even) refuse("the log's frames are not stamped number times frame period");
  if (found.last_stamp < run_length)
    refuse(fmt::format("the log ends at {}, but the run needs {}; shorten the run or use a longer log",
                       seconds(found.last_stamp), seconds(run_length)));

  // the log's robots and frame period are in force, whatever the keys for other arenas say
  for (const char* key : {"robots", "frame_period_s", "pace", "shape", "corners", "obstacles", "objects"})
    arena.leave_alone(key);
  ArenaInfo info{robot};
  info.name = lab;
  info.platform = "replay";
  info.robots.assign(found.robots.begin(), found.robots.end());
  if (found.frame_period > LabTime{0}) info.frame_period = found.frame_period;
  const auto is_side = [](double side_m) { return side_m > 0 && side_m <= 100; };
  if (found.info && is_side(found.info->width_m) && is_side(found.info->height_m)) {
    for (const char* key : {"width_m", "height_m"}) arena.leave_alone(key);
    info.width_m = found.info->width_m;
    info.height_m = found.info->height_m;
  } else {
    const auto sides = arena.read<ArenaSides>();
    info.width_m = sides.width_m;
    info.height_m = sides.height_m;
  }
  if (found.info && found.info->max_robot >= 0 && found.info->kinds >= 0 && found.info->kinds <= 255 &&
      found.info->values >= 0 && found.info->values <= 1 << 24) {
    info.max_robot = static_cast<RobotId>(found.info->max_robot);
    info.kinds = static_cast<std::uint8_t>(found.info->kinds);
    info.values = static_cast<std::uint32_t>(found.info->values);
    info.id_bits = found.info->id_bits;
    info.kind_bits = found.info->kind_bits;
    info.message_type = found.info->message_type;
    info.whole = static_cast<WholeMessages>(std::min<int>(found.info->whole, static_cast<int>(WholeMessages::to_each)));
  }
  if (found.info && found.info->body_radius_m > 0 && found.info->body_radius_m < info.width_m) {
    info.body_radius_m = found.info->body_radius_m;
    info.make = found.info->make;
    static_cast<RobotKind&>(info).height_m = found.info->body_height_m;
  }
  if (found.info && !read_solids(*found.info, info)) refuse("the log's description of its arena contradicts itself");
  if (!found.same_objects || info.objects.size() != found.objects)
    refuse(fmt::format("the log's frames do not all hold the {} objects of its arena", info.objects.size()));
  return std::make_unique<LogArena>(file, std::move(info), found.last_stamp);
}

}  // namespace arkmesh::hal
