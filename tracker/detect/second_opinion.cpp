// See second_opinion.hpp.
#include "tracker/detect/second_opinion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "tracker/detect/impostor.hpp"
#include "tracker/detect/median.hpp"

namespace arkmesh::tracker {
namespace {

constexpr double least_score = 0.3;     // of the net, for a closer look
constexpr double surely_seen = 0.7;     // confidence in what only the net has seen
constexpr double least_likeness = 0.5;  // of that: plain discs and rings have none
constexpr double fewest_of_own = 3;     // beyond doubt, where nothing else was found
constexpr std::size_t max_sizes = 6;    // that are looked at closely, of those that the net sees
// Chosen on the 60 plain and strange rendered rooms, and on things that are no robots in the given pictures:
constexpr double weak_edge = 0.15;    // the median step over edges, of the brightness there
constexpr double likely_seen = 0.5;   // there, instead of surely_seen
constexpr double surely_alone = 0.6;  // of the net's scores there, where no edge can be measured
constexpr double same_size = 0.15;    // the logarithm of the ratio of radii there
constexpr double much_larger = 1.16;  // circles of the net than those found

bool are_close(const NetFind& find, const Candidate& one, double within_px) {
  const Circle &a = find.circle, &b = one.circle_fit.circle;
  return std::hypot(a.x_px - b.x_px, a.y_px - b.y_px) < within_px;
}

}  // namespace

void SecondOpinion::look_at(const cv::Mat& bgr) {
  bgr_ = bgr;
  finds_r_px_ = 0;
  net_.look_at(bgr);
}

void SecondOpinion::find(double r_px) {
  if (std::exchange(finds_r_px_, r_px) == r_px) return;
  finds_.clear();
  net_.find(r_px, least_score, finds_);
}

std::vector<double> SecondOpinion::scores(const std::vector<Candidate>& robots) {
  std::vector<double> scores(robots.size(), 0);
  if (robots.empty()) return scores;
  const double r_px = BodySearch::median_r_px(robots);
  find(r_px);
  for (std::size_t i = 0; i < robots.size(); ++i)
    for (const NetFind& one : finds_)
      if (are_close(one, robots[i], 0.5 * r_px)) scores[i] = std::max(scores[i], one.score);
  return scores;
}

std::vector<Candidate> SecondOpinion::with_more(std::vector<Candidate> robots, bool any_size) {
  const auto most = [&](auto count) { return !robots.empty() && 2 * static_cast<std::size_t>(count) >= robots.size(); };
  const Agreed agreed = agreement(robots);
  const bool seen_there = most(agreed.places);
  if (!any_size || (seen_there && most(agreed.sizes))) {
    if (!seen_there) return robots;
    return joined(std::move(robots), agreed.places < enough_robots ? Beside::few : Beside::clear);
  }
  std::vector<Candidate> own = of_any_size(seen_there ? agreed.sizes : agreed.places);
  // Where the net sees robots that are larger, they must lie round most of what was found.
  if (seen_there && !most(std::ranges::count_if(robots, [&](const Candidate& cell) {
        return std::ranges::any_of(own, [&](const Candidate& body) {
          const Circle &inner = cell.circle_fit.circle, &outer = body.circle_fit.circle;
          return outer.r_px > much_larger * inner.r_px &&
                 std::hypot(outer.x_px - inner.x_px, outer.y_px - inner.y_px) < 0.4 * outer.r_px;
        });
      })))
    return joined(std::move(robots), agreed.places < enough_robots ? Beside::few : Beside::clear);
  if (own.empty()) return robots;
  std::vector<double> edges;
  for (const Candidate& one : own) edges.push_back(one.weber);
  return median(std::move(edges)) < weak_edge ? joined(std::move(own), Beside::weak) : own;
}

std::vector<Candidate> SecondOpinion::of_any_size(std::size_t agreed) {
  finds_.clear();
  finds_r_px_ = 0;
  for (double r_px = settings_.smallest_diameter_px / 2; r_px < settings_.largest_diameter_px / 2;
       r_px *= std::numbers::sqrt2)
    net_.find(r_px, least_score, finds_);
  const std::vector<SizeEvidence> sizes = size_evidence(finds_, bgr_.cols, bgr_.rows);
  std::vector<Candidate> best;
  double most = std::max(static_cast<double>(agreed), fewest_of_own);
  for (std::size_t i = 0; i < std::min(sizes.size(), max_sizes); ++i) {
    std::vector<Candidate> some = seen(sizes[i].r_px, Beside::few);
    if (some.empty()) continue;
    // Again at the size that the edges have.
    some = seen(BodySearch::median_r_px(some), Beside::few);
    double votes = 0;
    for (const Candidate& one : some)
      votes += std::pow(one.evidence, 4) * std::min(1.0, one.circle_fit.circle.r_px / 8);
    if (votes > most) most = votes, best = std::move(some);
  }
  return best;
}

// How many the net sees, too; and not much larger, as where coin cells were taken for robots. What is larger round
// holes is no robot either.
SecondOpinion::Agreed SecondOpinion::agreement(const std::vector<Candidate>& robots) {
  Agreed agreed;
  if (robots.empty()) return agreed;
  const double r_px = BodySearch::median_r_px(robots);
  find(r_px);
  for (const Candidate& robot : robots) {
    const auto near = [&](const NetFind& one) { return one.score > surely_net && are_close(one, robot, 0.5 * r_px); };
    if (std::ranges::none_of(finds_, near)) continue;
    ++agreed.places;
    agreed.sizes += why_no_robot(bgr_, robot.circle_fit) || std::ranges::any_of(finds_, [&](const NetFind& one) {
                      return near(one) && one.circle.r_px < much_larger * robot.circle_fit.circle.r_px;
                    });
  }
  return agreed;
}

// And what the net sees besides; what was found already keeps its place. Where that is more than was found, it must
// look like robots.
std::vector<Candidate> SecondOpinion::joined(std::vector<Candidate> robots, Beside beside) {
  const double r_px = BodySearch::median_r_px(robots);
  Places places(1.5 * r_px, bgr_.cols, bgr_.rows);
  for (const Candidate& one : robots) places.add(one.circle_fit.circle);
  std::vector<Candidate> more = seen(r_px, beside, robots);
  if (more.size() > robots.size()) more = seen(r_px, Beside::few, robots);
  for (const Candidate& one : more)
    if (!places.taken(one.circle_fit.circle, 1.5 * r_px)) robots.push_back(one);
  std::sort(robots.begin(), robots.end());
  return robots;
}

std::vector<Candidate> SecondOpinion::seen(double r_px, Beside beside, std::span<const Candidate> known) {
  find(r_px);
  std::vector<Candidate> robots;
  for (const NetFind& one : finds_) {
    if (std::ranges::any_of(known, [&](const Candidate& robot) { return are_close(one, robot, 0.5 * r_px); })) continue;
    std::optional<Candidate> best;
    for (const double r : {one.circle.r_px, r_px})
      for (const bool darker : {true, false})
        if (const auto circle_fit =
                bodies_.fit(bgr_, {one.circle.x_px, one.circle.y_px, r}, r == r_px ? 0.14 : 0.22, darker)) {
          Candidate robot = candidate(*circle_fit);
          robot.evidence = confidence(robot, one.score, r_px);
          if (!best || robot.evidence > best->evidence) best = robot;
        }
    if (best && best->evidence > (beside == Beside::weak ? likely_seen : surely_seen) &&
        best->likeness > (beside == Beside::few ? least_likeness : 0) && best->circle_fit.inside > 0.6F) {
      robots.push_back(*best);
    } else if (beside == Beside::weak && one.score > surely_alone &&
               std::abs(std::log(one.circle.r_px / r_px)) < same_size) {
      Candidate robot;
      robot.circle_fit.circle = {one.circle.x_px, one.circle.y_px, (one.circle.r_px + r_px) / 2};
      robot.evidence = one.score;
      robots.push_back(robot);
    }
  }
  return BodySearch::united(bgr_, {robots});
}

}  // namespace arkmesh::tracker
