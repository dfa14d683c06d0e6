// Robots that answer questions about their ids as arkmesh_id.h has it, the air between, and a camera that looks at them
// late, misses LEDs and takes some for others. For tests of identification without bodies.
#pragma once

#include <algorithm>
#include <deque>
#include <numeric>
#include <optional>
#include <vector>

#include "hal/random.hpp"
#include "tracker/follow/track.hpp"
#include "tracker/identity/id_code.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::tracker {

struct Conditions {
  double loss = 0;    // probability that a robot misses a copy of a message
  double unseen = 0;  // that a picture does not show an LED
  double wrong = 0;   // that it shows another colour
  hal::LabTime latency{150'000};
  hal::LabTime frame{100'000};
  hal::LabTime spacing{60'000};  // of messages on the air
};

class SpellingRobots {
 public:
  struct Robot {
    hal::RobotId id = 0;
    TrackNumber track = 0;
    hal::Led own = hal::Led::blue;  // what its program shows
    std::optional<hal::Led> answer;
    hal::LabTime heard_at{0};
    bool deaf = false, dark = false, hidden = false;
    bool doubtful = false;  // what a tracker thinks
    std::optional<hal::RobotId> named;
    hal::LabTime hidden_since{0};
    int answers = 0;  // questions answered with another colour than before
  };

  SpellingRobots(std::vector<hal::RobotId> ids, Conditions conditions, std::uint64_t seed = 1)
      : conditions_(conditions), chance_(seed, "test/robots") {
    // tracks are numbered in no order of ids
    std::vector<TrackNumber> tracks(ids.size());
    std::iota(tracks.begin(), tracks.end(), 100u);
    for (std::size_t i = tracks.size(); i > 1; --i) std::swap(tracks[i - 1], tracks[chance_.below(i)]);
    for (std::size_t i = 0; i < ids.size(); ++i) robots.push_back({.id = ids[i], .track = tracks[i]});
  }

  // Until the next picture; `question` goes on the air as long as it lasts. Returns the tracks in the picture,
  // ascending.
  const std::vector<Track>& next_picture(const std::optional<Question>& question) {
    now += conditions_.frame;
    for (; next_air_ <= now; next_air_ += conditions_.spacing) {
      if (question) on_air(next_air_, *question);
      // the world as it was is what a late camera sees
      past_.push_back({next_air_, leds(next_air_)});
    }
    while (past_.size() > 1 && past_[1].at <= now - conditions_.latency) past_.pop_front();
    tracks_.clear();
    for (std::size_t i = 0; i < robots.size(); ++i) {
      const Robot& robot = robots[i];
      Track track{.number = robot.track, .confidence = 1, .robot = robot.named, .doubtful = robot.doubtful};
      track.led = past_.front().leds[i];
      track.led_seen = track.led != hal::Led::off && chance_.uniform() >= conditions_.unseen;
      if (chance_.uniform() < conditions_.wrong) track.led = static_cast<hal::Led>(1 + chance_.below(7));
      if (robot.hidden) {
        track.age = now - robot.hidden_since;
        track.led_seen = false;
        if (track.age > hal::LabTime{1'000'000}) continue;
      }
      tracks_.push_back(track);
    }
    std::sort(tracks_.begin(), tracks_.end(), [](const Track& a, const Track& b) { return a.number < b.number; });
    return tracks_;
  }
  Robot& by_id(hal::RobotId id) {
    return *std::find_if(robots.begin(), robots.end(), [id](const Robot& robot) { return robot.id == id; });
  }
  const Robot& by_track(TrackNumber track) const {
    return *std::find_if(robots.begin(), robots.end(), [track](const Robot& robot) { return robot.track == track; });
  }
  double seconds() const { return static_cast<double>(now.count()) * 1e-6; }

  std::vector<Robot> robots;
  hal::LabTime now{0};

 private:
  struct Past {
    hal::LabTime at;
    std::vector<hal::Led> leds;
  };
  std::vector<hal::Led> leds(hal::LabTime at) {
    std::vector<hal::Led> out;
    for (Robot& robot : robots) {
      if (robot.answer && at - robot.heard_at > hal::LabTime{3'000'000}) robot.answer.reset();
      out.push_back(robot.dark ? hal::Led::off : robot.answer.value_or(robot.own));
    }
    return out;
  }
  void on_air(hal::LabTime at, const Question& message) {
    const auto id_at = [&message](std::size_t i) {
      return static_cast<hal::RobotId>(message.data[i] << 8 | message.data[i + 1]);
    };
    for (Robot& robot : robots) {
      if (robot.deaf || chance_.uniform() < conditions_.loss) continue;
      std::optional<hal::Led> answer;
      if (message.type == question_type) {
        const unsigned who = message.data[0] >> 6;
        const bool asked = who == 1 || (who == 2 && id_at(1) <= robot.id && robot.id <= id_at(3)) ||
                           (who == 3 && (id_at(1) == robot.id || id_at(3) == robot.id || id_at(5) == robot.id ||
                                         id_at(7) == robot.id));
        if (asked) answer = spelled(robot.id, message.data[0] & 63);
      } else if (message.type == ark_initial_type || message.type == ark_runtime_type) {
        if (id_at(0) != nobody) answer = id_at(0) == robot.id ? hal::Led::blue : hal::Led::red;
      }
      if (answer && answer != robot.answer) ++robot.answers;
      robot.answer = answer;
      robot.heard_at = at;
    }
  }

  Conditions conditions_;
  hal::RandomStream chance_;
  hal::LabTime next_air_{0};
  std::deque<Past> past_;
  std::vector<Track> tracks_;
};

inline std::vector<hal::RobotId> ids_from_0(std::size_t n) {
  std::vector<hal::RobotId> out(n);
  std::iota(out.begin(), out.end(), 0u);
  return out;
}

}  // namespace arkmesh::tracker
