#include "tracker/identity/id_assigner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace arkmesh::tracker {
namespace {

// Types of messages as in ARK's assignment.
constexpr std::uint8_t draw_type = 1, store_type = 2, draw_anew_type = 3;
// Long enough for 16, 4 and 2 copies at 60 ms; what is missed all the same is found out when everybody is read.
constexpr hal::LabTime draw_lasts{1'000'000}, draw_anew_lasts{250'000}, storing_lasts{130'000}, end_lasts{600'000};

Question message(std::uint8_t type, std::array<std::uint32_t, 4> numbers) {
  Question out{.type = type};
  for (std::size_t i = 0; i < 4; ++i) {
    out.data[2 * i] = static_cast<std::uint8_t>(numbers[i] >> 8);
    out.data[2 * i + 1] = static_cast<std::uint8_t>(numbers[i]);
  }
  return out;
}

}  // namespace

IdAssigner::IdAssigner(AssignmentSettings settings)
    : settings_(std::move(settings)), reader_(settings_.times, counters_) {
  announcements_.add(message(draw_type, {static_cast<std::uint32_t>(settings_.session) << 8, 0, 0, 0}), draw_lasts);
}

void IdAssigner::on_frame(hal::LabTime now, std::span<const Track> tracks) {
  update_robots(tracks);
  if (phase_ == Phase::finished || announcements_.say(now)) return;
  switch (phase_) {
    case Phase::drawing:
      read(Phase::reading);
      break;
    case Phase::storing:
      read(Phase::checking);
      break;
    case Phase::reading:
    case Phase::checking:
      reader_.on_frame(now, tracks);
      if (reader_.asking()) break;
      // their programs have work to do
      announcements_.add(end_of_questions(), end_lasts);
      phase_ == Phase::reading ? use_drawn() : use_checked();
      announcements_.say(now);
      break;
    case Phase::ending:
      phase_ = Phase::finished;
      break;
    case Phase::finished:
      break;
  }
}

void IdAssigner::update_robots(std::span<const Track> tracks) {
  std::map<TrackNumber, Robot> robots;
  for (const Track& track : tracks) {
    auto at = robots_.find(track.number);
    Robot robot = at == robots_.end() ? Robot{} : at->second;
    if (track.doubtful && robot.temporary && robot.outcome != Outcome::confirmed) {
      // it may be another one now
      counters_.add("assignment.doubted");
      reader_.forget(track.number);
      robot = {};
    }
    robot.in_arena = track.in_arena;
    robots.emplace(track.number, robot);
  }
  for (const auto& [number, robot] : robots_)
    if (!robots.contains(number)) {
      counters_.add("assignment.lost");
      reader_.forget(number);
    }
  robots_ = std::move(robots);
}

void IdAssigner::read(Phase phase) {
  phase_ = phase;
  reader_.ask({}, max_id_digits);
}

// Everybody's temporary id, if it is one of its own; else another round. What was read in an earlier round holds until
// something else is read.
void IdAssigner::use_drawn() {
  bool somebody_missed_it = false;
  for (const auto& reading : reader_.take_readings()) {
    const auto at = robots_.find(reading.track);
    if (at == robots_.end()) continue;
    at->second.temporary.reset();
    at->second.outcome = Outcome::unread;
    if (reading.robot < first_temporary_id) {
      somebody_missed_it = true;
      counters_.add("assignment.repeated.not_drawn");
    } else {
      at->second.temporary = reading.robot;
      at->second.outcome = Outcome::drawn;
    }
  }
  std::map<hal::RobotId, int> holders;
  for (const auto& [number, robot] : robots_)
    if (robot.temporary) ++holders[*robot.temporary];
  std::set<hal::RobotId> doubles;
  for (auto& [number, robot] : robots_) {
    if (!robot.temporary || holders[*robot.temporary] == 1) continue;
    doubles.insert(*robot.temporary);
    counters_.add("assignment.repeated.double");
    robot.temporary.reset();
    robot.outcome = Outcome::unread;
  }
  const bool everybody = std::all_of(robots_.begin(), robots_.end(),
                                     [](const auto& robot) { return robot.second.outcome != Outcome::unread; });
  if (everybody || round_ >= settings_.max_rounds) {
    round_ = 1;
    give_ids();
    return announce_ids();
  }
  ++round_;
  for (hal::RobotId robot : doubles) announcements_.add(message(draw_anew_type, {robot, 0, 0, 0}), draw_anew_lasts);
  if (somebody_missed_it)
    announcements_.add(message(draw_type, {static_cast<std::uint32_t>(settings_.session) << 8, 0, 0, 0}), draw_lasts);
  phase_ = Phase::drawing;
}

// In rows from north to south, each from west to east.
void IdAssigner::give_ids() {
  std::vector<Robot*> order;
  for (auto& [number, robot] : robots_)
    if (robot.outcome == Outcome::drawn) order.push_back(&robot);
  const auto row = [](const Robot* robot) { return -std::floor(robot->in_arena.y_m / 0.05); };
  std::stable_sort(order.begin(), order.end(), [&](const Robot* a, const Robot* b) {
    return row(a) != row(b) ? row(a) < row(b) : a->in_arena.x_m < b->in_arena.x_m;
  });
  for (Robot* robot : order) {
    if (next_id_ == settings_.ids.size()) {
      robot->outcome = Outcome::no_id_left;
      continue;
    }
    robot->given = settings_.ids[next_id_++];
    robot->outcome = Outcome::given;
  }
}

// Two robots in each message.
void IdAssigner::announce_ids() {
  std::vector<const Robot*> waiting;
  for (const auto& [number, robot] : robots_)
    if (robot.outcome == Outcome::given) waiting.push_back(&robot);
  for (std::size_t i = 0; i < waiting.size(); i += 2) {
    const bool two = i + 1 < waiting.size();
    announcements_.add(
        message(store_type, {*waiting[i]->temporary, *waiting[i]->given, two ? *waiting[i + 1]->temporary : nobody,
                             two ? *waiting[i + 1]->given : nobody}),
        storing_lasts);
  }
  announced_ = announcements_.waiting();
  phase_ = waiting.empty() ? Phase::ending : Phase::storing;
}

// Who spells its new id has it; who spells its temporary one, or nothing, is told again.
void IdAssigner::use_checked() {
  bool all = true;
  std::map<TrackNumber, hal::RobotId> spelled;
  for (const auto& reading : reader_.take_readings()) spelled[reading.track] = reading.robot;
  for (auto& [number, robot] : robots_) {
    if (robot.outcome != Outcome::given) continue;
    const auto at = spelled.find(number);
    if (at != spelled.end() && at->second == *robot.given) {
      robot.outcome = Outcome::confirmed;
    } else {
      all = false;
      counters_.add(at == spelled.end() ? "assignment.repeated.unread" : "assignment.repeated.not_stored");
    }
  }
  if (all || round_ >= settings_.max_rounds) {
    phase_ = Phase::ending;
    return;
  }
  ++round_;
  announce_ids();
}

std::optional<Question> IdAssigner::question() const {
  if (announcements_.waiting() > 0) return announcements_.message();
  if (phase_ == Phase::reading || phase_ == Phase::checking) return reader_.question();
  return std::nullopt;
}

IdAssigner::Progress IdAssigner::progress() const {
  Progress out{.round = round_};
  if (phase_ == Phase::reading || phase_ == Phase::checking) {
    out.done = reader_.position();
    out.of = reader_.digits();
  } else if (phase_ == Phase::storing) {
    out.done = static_cast<int>(announced_ - announcements_.waiting());
    out.of = static_cast<int>(announced_);
  }
  for (const auto& [number, robot] : robots_) out.confirmed += robot.outcome == Outcome::confirmed;
  return out;
}

std::string_view name_of(IdAssigner::Phase phase) {
  constexpr std::string_view names[] = {
      "drawing temporary ids", "reading temporary ids", "storing new ids", "reading new ids", "ending", "finished"};
  return names[static_cast<std::size_t>(phase)];
}

std::string_view name_of(IdAssigner::Outcome outcome) {
  constexpr std::string_view names[] = {"does not answer", "not given", "not confirmed", "confirmed", "no id left"};
  return names[static_cast<std::size_t>(outcome)];
}

}  // namespace arkmesh::tracker
