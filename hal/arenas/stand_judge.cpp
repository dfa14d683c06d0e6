#include "hal/arenas/stand_judge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace arkmesh::hal {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds gap = 500ms;  // out of sight for longer: what came between is not known
// A walk goes on, a jump of the measurement (a hand at the robot's edge) does not: of four parts of the time at least
// three have a fifth of the way.
constexpr int parts = 4, parts_of_a_walk = 3;
constexpr double least_part = 0.2;
// A heading counts when it is measured to three degrees. Who turns by more than twenty, in steps none of which is much
// less than another, moves.
constexpr double known_heading_rad = 3 * std::numbers::pi / 180, still_within_rad = 20 * std::numbers::pi / 180;
constexpr double least_step = 0.5;
// Who comes four times as far as a robot can in so short a time, 2 s of its speed, was carried.
constexpr std::chrono::milliseconds carry_time = 500ms;

struct Spot {
  double x_m, y_m;
};

double distance_m(Spot a, Spot b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

double middle(std::vector<double> values) {
  const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  return *half;
}

// Where a robot was around the `i`th look: a single measurement that is off does not count.
template <typename Places>
Spot spot(const Places& places, std::size_t i) {
  const std::size_t n = std::min<std::size_t>(3, places.size());
  const std::size_t from = std::min(i - std::min(i, n / 2), places.size() - n);
  std::vector<double> x, y;
  for (std::size_t k = from; k < from + n; ++k) x.push_back(places[k].x_m), y.push_back(places[k].y_m);
  return {middle(std::move(x)), middle(std::move(y))};
}

}  // namespace

void StandJudge::begin() {
  seen_.clear();
  rests_.clear();
  resting_.clear();
}

void StandJudge::look(const PoseFrame& frame, TimePoint now) {
  for (const Observation& robot : frame.robots) {
    const Place place{now - robot.age, robot.pose.x_m, robot.pose.y_m, robot.pose.heading_rad,
                      robot.heading_noise_rad < known_heading_rad};
    Places& places = seen_[robot.robot];
    if (place.at <= newest_[robot.robot]) continue;
    newest_[robot.robot] = place.at;
    if (!places.empty() && now - places.back().at > gap) places.clear();
    const auto before = std::ranges::find_if(places, [&](const Place& p) { return now - p.at <= carry_time; });
    if (before != places.end() && distance_m({before->x_m, before->y_m}, {place.x_m, place.y_m}) > 2.0 * fastest_m_s_) {
      places.clear();
      carried_.push_back(robot.robot);
    }
    places.push_back(place);
    while (places.size() > 2 && now - places[1].at >= looks_for) places.pop_front();
    Rest& rest = rests_.try_emplace(robot.robot, Rest{place}).first->second;
    if (distance_m({rest.at.x_m, rest.at.y_m}, {place.x_m, place.y_m}) > still_within_m || turns(places)) {
      rest = {place, rests_after, places.size() > 1};  // else it was carried, or out of sight
      if (rest.came) walked_[robot.robot] = place.at;
    } else if (place.at - rest.at.at >= rest.until) {
      rest.until *= 2;
      resting_.push_back(robot.robot);
    }
  }
}

// The look with which each part ends, and the first.
std::vector<std::size_t> StandJudge::ends_of_parts(const Places& places) {
  std::vector<std::size_t> out{0};
  for (int part = 1; part <= parts; ++part) {
    const TimePoint end = places.back().at - looks_for * (parts - part) / parts;
    const auto at = std::ranges::find_if(places, [&](const Place& place) { return place.at >= end; });
    out.push_back(static_cast<std::size_t>(at - places.begin()));
  }
  return out;
}

// Who goes round in a circle may be back where it was: each part's end counts.
std::optional<NotStanding::Why> StandJudge::judge(const Places& places, TimePoint now) const {
  using Why = NotStanding::Why;
  if (places.empty() || now - places.back().at > gap) return Why::not_in_sight;
  if (places.back().at - places.front().at < looks_for) return Why::not_yet;
  if (turns(places)) return Why::moving;
  const std::vector<std::size_t> ends = ends_of_parts(places);
  const Spot first = spot(places, 0), last = spot(places, places.size() - 1);
  const double way_x = last.x_m - first.x_m, way_y = last.y_m - first.y_m, way2 = way_x * way_x + way_y * way_y;
  int with_a_part = 0;
  double far_m = 0;
  Spot before = first;
  for (int part = 1; part <= parts; ++part) {
    const Spot after = spot(places, ends[static_cast<std::size_t>(part)]);
    const double along = (after.x_m - before.x_m) * way_x + (after.y_m - before.y_m) * way_y;
    with_a_part += along >= least_part * way2;
    far_m = std::max(far_m, distance_m(first, after));
    before = after;
  }
  if (far_m <= still_within_m) return {};
  return way2 > still_within_m * still_within_m && with_a_part >= parts_of_a_walk ? Why::moving : Why::not_yet;
}

// Whether it goes on turning the one way or the other: from each quarter's middle heading to the next in like steps. An
// LED that changes, or glare, makes one step. False where the heading is not known.
bool StandJudge::turns(const Places& places) {
  std::vector<std::vector<double>> known(parts);
  for (std::vector<double>& part : known) part.reserve(places.size());
  for (const Place& place : places) {
    const auto part = parts - 1 - (places.back().at - place.at) * parts / (looks_for + 1ms);
    if (place.heading_known && part >= 0) known[static_cast<std::size_t>(part)].push_back(place.heading_rad);
  }
  double before_rad = 0, all_rad = 0, least_rad = std::numbers::pi, most_rad = 0;
  for (std::size_t part = 0; part < known.size(); ++part) {
    if (known[part].size() < 3) return false;
    if (part == 0) before_rad = known[part].front();
    for (double& heading : known[part]) heading = std::remainder(heading - before_rad, 2 * std::numbers::pi);
    const double step_rad = middle(known[part]);
    before_rad += step_rad;
    if (part == 0) continue;
    all_rad += step_rad;
    least_rad = std::min(least_rad, std::abs(step_rad));
    most_rad = std::max(most_rad, std::abs(step_rad));
    if (step_rad * all_rad <= 0) return false;
  }
  return std::abs(all_rad) > still_within_rad && least_rad > least_step * most_rad;
}

std::vector<NotStanding> StandJudge::not_standing(TimePoint now) const {
  std::vector<NotStanding> out;
  for (const RobotId robot : robots_) {
    const auto seen = seen_.find(robot);
    using Why = NotStanding::Why;
    const auto why = !newest_.contains(robot) ? Why::not_named
                     : seen == seen_.end()    ? Why::not_in_sight
                                              : judge(seen->second, now);
    if (why) out.push_back({robot, *why});
  }
  return out;
}

bool StandJudge::most_walk_on(TimePoint told) const {
  const auto walked =
      std::ranges::count_if(walked_, [&](const auto& robot) { return robot.second > told - looks_for; });
  const auto on = std::ranges::count_if(rests_, [](const auto& robot) { return robot.second.came; });
  return on > 0 && 2 * on >= walked;
}

std::vector<RobotId> StandJudge::take_carried() {
  std::ranges::sort(carried_);
  carried_.erase(std::unique(carried_.begin(), carried_.end()), carried_.end());
  return std::exchange(carried_, {});
}

}  // namespace arkmesh::hal
