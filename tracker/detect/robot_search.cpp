// See robot_search.hpp.
#include "tracker/detect/robot_search.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <utility>

#include "tracker/detect/impostor.hpp"

namespace arkmesh::tracker {
namespace {

// Chosen on 60 plain and strange rendered rooms and on changed real pictures, as the weights of confidence() were:
constexpr double unseen = 0.05;          // the net's score where it sees nothing
constexpr double least_score = 0.1;      // of the net, for a closer look
constexpr std::size_t most_looks = 300;  // of those that edges did not propose
constexpr double sizes_score = 0.3;      // likewise, to name a size
constexpr double usual_share = 0.7;      // of what is looked at, that are robots, where confidence() holds; the most
constexpr double surely_one = 0.97;      // the probability of one robot at least ...
constexpr double mostly = 0.85;          // ... and of half of them; else all are clutter that resembles robots
constexpr double beyond_doubt = 0.95;    // that of each, where there are fewer than enough_robots ...
constexpr double clearly_one = 0.75;     // ... unless its edge and what is inside leave no doubt by themselves
constexpr double clear_enough = 0.65;
constexpr double large_px = 64, large_one = 0.995;  // few circles larger than that are more often something else
constexpr double few_places_px = 8;                 // radius from which chance resemblances are rare
constexpr double measured_small = 0.9;              // the median of measured sizes in parts of the true one, at least
constexpr std::size_t edge_sizes = 4;               // that are tried, of those that edges name
constexpr std::size_t net_sizes = 6;                // likewise of those that the net sees
constexpr double net_votes = 0.25;                  // evidence they need; sizes that led to robots had 0.33
constexpr double net_reach = 1.3;                   // it finds radii down to the one asked for divided by this
constexpr double worth_search = 0.8;      // the least likeliest close look at a size that led to robots is 0.97 ...
constexpr std::size_t first_looks = 60;   // ... among so many
constexpr double same_size = 0.06;        // the logarithm of the ratio of radii
constexpr double next_size = 1.065;       // the ratio of neighbouring sizes tried beside a given one
constexpr double other_size = 0.35;       // the same of robots of one picture, at most: a view may slant
constexpr double cells[] = {0.65, 0.74};  // the radius of coin cells in parts of the board's

double apart(const Circle& a, const Circle& b) {
  return std::hypot(a.x_px - b.x_px, a.y_px - b.y_px);
}

// Most of `inner` have one of `outer` round them, which is as much larger as a board than its coin cell.
bool lies_round(const std::vector<Candidate>& outer, const std::vector<Candidate>& inner) {
  const auto inside = std::ranges::count_if(inner, [&](const Candidate& cell) {
    return std::ranges::any_of(outer, [&](const Candidate& body) {
      const Circle &a = cell.circle_fit.circle, &b = body.circle_fit.circle;
      return b.r_px > 1.2 * a.r_px && b.r_px < 1.7 * a.r_px && apart(a, b) < 0.4 * b.r_px;
    });
  });
  return 2 * inside > std::ssize(inner);
}

// Adapts probabilities for the usual share of robots to the share in this picture, found by expectation maximisation
// (Saerens et al., Neural Computation 14, 2002): among clutter a robot must be likelier. Returns the share.
double adapt_to_share(std::vector<Candidate>& all) {
  const auto logit = [](double p) { return std::log(p / (1 - p)); };
  std::vector<double> odds;
  for (const Candidate& one : all) odds.push_back(logit(std::clamp(one.evidence, 1e-9, 1 - 1e-9)) - logit(usual_share));
  double share = usual_share;
  for (int turn = 0; turn < 20; ++turn) {
    double robots = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i].evidence = 1 / (1 + std::exp(-odds[i] - logit(share)));
      robots += all[i].evidence;
    }
    share = std::min(usual_share, robots / (static_cast<double>(all.size()) + 1));
  }
  return share;
}

// The probability of a robot, given confidence() and what LookNet says. The weights are near those of a logistic
// regression on the pictures of confidence(): 0.85, 0.85 and a constant of -0.2 over right and wrong sizes, 0.88, 0.85
// and 0.3 at right ones. 0.5 finds more of the robots that touch others. Small circles fit into more places of a
// picture and show fewer details, each by the square of their size, so more of them resemble a robot by chance.
double after_look(double before, double look, double r_px) {
  const auto logit = [](double p, double least) {
    const double sure = std::clamp(p, least, 1 - least);
    return std::log(sure / (1 - sure));
  };
  const double places = std::min(0.0, 4 * std::log(r_px / few_places_px));
  return 1 / (1 + std::exp(-0.9 * logit(before, 1e-3) - 0.85 * logit(look, 1e-5) - 0.5 - places));
}

}  // namespace

void RobotSearch::look_at(const cv::Mat& bgr) {
  bgr_ = bgr;
  last_ = {};
  net_.look_at(bgr);
}

std::vector<Candidate> RobotSearch::about_diameter(double diameter_px) {
  last_ = of_size(diameter_px, bodies_.about_diameter(bgr_, diameter_px));
  return last_.robots;
}

std::vector<Candidate> RobotSearch::of_any_size(std::optional<double> diameter_px) {
  last_ = {};
  // Near a figure that led to no certain result, a slightly different size may.
  const double same = diameter_px ? same_size / 2 : same_size;
  std::vector<double> tried;
  const auto known = [&](double r_px) {
    return std::ranges::any_of(tried, [&](double other) { return std::abs(std::log(r_px / other)) < same; });
  };
  const auto better = [&](double r_px) {
    if (!(r_px > 0) || known(r_px)) return false;
    tried.push_back(r_px);
    OfSize one = of_size(2 * r_px, bodies_.bodies_or_cells(bgr_, 2 * r_px));
    // Again at the size that they have.
    if (const double found_px = BodySearch::median_r_px(one.robots);
        !one.robots.empty() && !one.convincing && std::abs(std::log(found_px / r_px)) > same_size / 2) {
      OfSize again = of_size(2 * found_px, bodies_.about_diameter(bgr_, 2 * found_px));
      if (again.votes > one.votes) one = std::move(again);
      tried.push_back(found_px);
    }
    // The net's finds reach below the size asked for.
    if (!settings_.diameter_px &&
        BodySearch::median_r_px(one.robots) < measured_small * settings_.smallest_diameter_px / 2) {
      for (const Candidate& small : one.robots)
        bodies_.object(small.circle_fit.circle, small.evidence, "smaller than is searched unless the size is told");
      one = {.refused = std::move(one.refused)};
    }
    // What lies round another is the board round a coin cell.
    const double wanted = lies_round(one.robots, last_.robots) ? 0.5 : lies_round(last_.robots, one.robots) ? 2 : 1;
    if (one.votes > wanted * last_.votes || (last_.robots.empty() && one.refused.size() > last_.refused.size()))
      last_ = std::move(one);
    return last_.convincing;
  };
  if (diameter_px && better(*diameter_px / 2)) return last_.robots;
  // A figure that is a little wrong may show them all, their edges mixed up with what is inside or round them.
  for (const double step : {next_size, 1 / next_size})
    for (double r_px = step * diameter_px.value_or(0) / 2, votes = 0; last_.votes > votes; r_px *= step) {
      votes = last_.votes;
      if (better(r_px)) return last_.robots;
    }
  std::vector<SizeEvidence> sizes = bodies_.find_sizes(bgr_);
  sizes.resize(std::min(sizes.size(), edge_sizes));
  if (!sizes.empty() && better(sizes[0].r_px)) return last_.robots;
  std::vector<NetFind> finds;
  std::vector<SizeEvidence> others = sizes_of_net(finds);
  others.insert(others.end(), sizes.begin(), sizes.end());
  for (const SizeEvidence& size : others)
    if (!known(size.r_px) && best_look(finds, size.r_px) > worth_search) better(size.r_px);
  if (tried.empty() && !others.empty()) better(others[0].r_px);
  // Were those their coin cells?
  for (const double cell : cells)
    if (!last_.robots.empty()) better(BodySearch::median_r_px(last_.robots) / cell);
  return last_.robots;
}

double RobotSearch::best_look(const std::vector<NetFind>& finds, double r_px) {
  std::vector<NetFind> of_size;
  std::ranges::copy_if(finds, std::back_inserter(of_size), [&](const NetFind& find) {
    return std::abs(std::log(find.circle.r_px / r_px)) < 3 * same_size;
  });
  std::ranges::stable_sort(of_size, std::greater{}, &NetFind::score);
  of_size.resize(std::min(of_size.size(), first_looks));
  std::vector<Circle> circles;
  for (const NetFind& find : of_size) circles.push_back(find.circle);
  const std::vector<double> looks = look_net_.probabilities(bgr_, circles);
  return looks.empty() ? 0 : std::ranges::max(looks);
}

std::vector<SizeEvidence> RobotSearch::sizes_of_net(std::vector<NetFind>& finds) {
  for (double r_px = net_reach * settings_.smallest_diameter_px / 2; r_px < settings_.largest_diameter_px / 2;
       r_px *= std::numbers::sqrt2)
    net_.find(r_px, sizes_score, finds);
  std::vector<SizeEvidence> sizes = size_evidence(finds, bgr_.cols, bgr_.rows);
  std::erase_if(sizes, [](const SizeEvidence& size) { return size.votes < net_votes; });
  sizes.resize(std::min(sizes.size(), net_sizes));
  return sizes;
}

Candidate RobotSearch::measured(const NetFind& find, const Likeness& others) {
  const double r_px = others.r_at(find.circle.x_px, find.circle.y_px), tolerance = settings_.diameter_tolerance;
  Candidate best;
  best.circle_fit.circle = {find.circle.x_px, find.circle.y_px, std::sqrt(find.circle.r_px * r_px)};
  best.evidence = confidence(best, others, tolerance, find);
  for (const double r : {r_px, find.circle.r_px})
    for (const bool darker : {true, false}) {
      if (best.evidence > beyond_doubt) return best;
      const auto circle_fit =
          bodies_.fit(bgr_, {find.circle.x_px, find.circle.y_px, r}, r == r_px ? 0.14 : 0.22, darker);
      if (!circle_fit) continue;
      Candidate robot = candidate(*circle_fit);
      robot.evidence = confidence(robot, others, tolerance, find);
      if (robot.evidence > best.evidence) best = robot;
    }
  return best;
}

std::vector<Candidate> RobotSearch::looked_at(std::vector<Candidate> proposed, double r_px) {
  const Likeness common = likeness(proposed, r_px, other_size);
  std::vector<NetFind> finds;
  net_.find(r_px, least_score, finds);
  std::ranges::stable_sort(finds, [](const NetFind& a, const NetFind& b) { return a.score > b.score; });
  std::vector<char> known(finds.size(), 0);
  for (Candidate& one : proposed) {
    const Circle& at = one.circle_fit.circle;
    const auto seen =
        std::ranges::find_if(finds, [&](const NetFind& find) { return apart(find.circle, at) < 0.5 * r_px; });
    one = candidate(one.circle_fit);
    one.evidence =
        confidence(one, common, settings_.diameter_tolerance, seen == finds.end() ? NetFind{at, unseen} : *seen);
    if (seen != finds.end() && one.evidence > beyond_doubt) known[static_cast<std::size_t>(seen - finds.begin())] = 1;
  }
  std::size_t looks = 0;
  for (std::size_t i = 0; i < finds.size() && looks < most_looks; ++i)
    if (!known[i]) proposed.push_back(measured(finds[i], common)), ++looks;
  std::vector<Candidate> found = BodySearch::united(bgr_, {proposed});
  std::vector<Circle> circles;
  for (const Candidate& one : found) circles.push_back(one.circle_fit.circle);
  const std::vector<double> looks_like = look_net_.probabilities(bgr_, circles);
  for (std::size_t i = 0; i < found.size(); ++i)
    found[i].evidence = after_look(found[i].evidence, looks_like[i], circles[i].r_px);
  std::stable_sort(found.begin(), found.end());
  return found;
}

RobotSearch::OfSize RobotSearch::of_size(double diameter_px, std::vector<Candidate> proposed) {
  const double r_px = proposed.empty() ? diameter_px / 2 : BodySearch::median_r_px(proposed);
  OfSize found{.robots = looked_at(std::move(proposed), r_px)};
  const auto refuse = [&](const Candidate& one, const char* why) {
    found.refused.push_back(one.circle_fit.circle);
    bodies_.object(one.circle_fit.circle, one.evidence, why);
    return true;
  };
  std::erase_if(found.robots, [&](const Candidate& one) {
    const char* const why = why_no_robot(bgr_, one.circle_fit);
    return why && refuse(one, why);
  });
  const double share = adapt_to_share(found.robots);
  const auto likelier = [&](double least) {
    return static_cast<std::size_t>(
        std::ranges::count_if(found.robots, [&](const Candidate& one) { return one.evidence >= least; }));
  };
  const auto clear = [](const Candidate& one) {
    return one.clear * candidate(one.circle_fit).evidence > clear_enough && one.circle_fit.circle.r_px < large_px;
  };
  const std::size_t likely = likelier(settings_.min_confidence);
  const bool none = likelier(surely_one) == 0 || 2 * likelier(mostly) < likely, few = likely < enough_robots;
  std::erase_if(found.robots, [&](const Candidate& one) {
    const bool large = one.circle_fit.circle.r_px > large_px;
    const double least = !few ? settings_.min_confidence : large ? large_one : clear(one) ? clearly_one : beyond_doubt;
    return (none || one.evidence < least) &&
           refuse(one, "unlikely to be a robot, judging by its edge and the trained nets");
  });
  for (const Candidate& one : found.robots)
    found.votes += std::pow(one.evidence, 8) * std::min(1.0, one.circle_fit.circle.r_px / 8);
  const auto dark = std::ranges::count_if(found.robots, [](const Candidate& one) { return one.circle_fit.darker; });
  const std::size_t sure = likelier(beyond_doubt), count = found.robots.size();
  found.convincing = 2 * dark > std::ssize(found.robots) &&
                     (count < enough_robots ? sure == count && std::ranges::all_of(found.robots, clear)
                                            : share > 0.6 && 4 * sure >= 3 * count);
  return found;
}

}  // namespace arkmesh::tracker
