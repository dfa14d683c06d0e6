#include "tracker/detect/body_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "tracker/detect/led_neighbours.hpp"
#include "tracker/detect/median.hpp"

namespace arkmesh::tracker {

namespace {

constexpr double max_single_px = 128;  // a single circle that is larger is more often something else than a robot
// Circles that are fitted and not likely robots, before a search among many is given up, and more of them for each
// likely robot. At the right size 667 fits show 588 of 600 touching robots, 150 show 38 of 40 on print.
constexpr std::size_t most_others = 500, others_to_each = 3;

}  // namespace

std::optional<Candidate> BodySearch::near(const cv::Mat& bgr, const Expected& place) {
  const double r_px = place.r_px, far_px = place.reach_px + 1.25 * r_px;
  // written so that not-a-number is refused, too
  if (!(r_px >= 2 && r_px < 10000 && place.reach_px >= 0 && far_px < 20000)) return {};
  if (!(place.x_px > -far_px && place.y_px > -far_px && place.x_px < bgr.cols + far_px &&
        place.y_px < bgr.rows + far_px))
    return {};
  // Mostly it is very nearly where it should be.
  if (const auto circle_fit = fitter_.fit(bgr, {place.x_px, place.y_px, r_px}, 0.22, true, noise_)) {
    const Candidate one = candidate(*circle_fit);
    const bool reached =
        std::hypot(circle_fit->circle.x_px - place.x_px, circle_fit->circle.y_px - place.y_px) <= place.reach_px;
    if (reached && one.evidence >= settings_.min_confidence &&
        std::abs(circle_fit->circle.r_px / r_px - 1) < 0.5 * settings_.diameter_tolerance)
      return one;
  }
  const int block = std::max(1, static_cast<int>(std::lround(r_px / 7.5)));
  picture_.take(bgr, static_cast<int>(place.x_px - far_px), static_cast<int>(place.y_px - far_px),
                static_cast<int>(place.x_px + far_px) + 2, static_cast<int>(place.y_px + far_px) + 2, block);
  votes_.look_at(picture_, min_step());
  std::optional<Candidate> best;
  double best_off_px = place.reach_px;
  for (const bool darker : {true, false}) {
    circle_votes_.clear();
    votes_.find(r_px * 0.92 / block, r_px * 1.08 / block, darker, 0.5, circle_votes_);
    if (circle_votes_.size() > 6) circle_votes_.resize(6);
    for (const CircleVote& vote : circle_votes_) {
      const Circle guess{picture_.picture_x(vote.x), picture_.picture_y(vote.y), r_px};
      if (std::hypot(guess.x_px - place.x_px, guess.y_px - place.y_px) > best_off_px + 0.3 * r_px) continue;
      const auto circle_fit = closely(bgr, guess, darker);
      if (!circle_fit || std::abs(circle_fit->circle.r_px / r_px - 1) > settings_.diameter_tolerance) continue;
      const Candidate one = candidate(*circle_fit);
      const double off_px = std::hypot(circle_fit->circle.x_px - place.x_px, circle_fit->circle.y_px - place.y_px);
      if (one.evidence < settings_.min_confidence || off_px > best_off_px) continue;
      best = one;
      best_off_px = off_px;
    }
    if (best) break;
  }
  return best;
}

std::optional<CircleFit> BodySearch::closely(const cv::Mat& bgr, const Circle& guess, bool darker) {
  const auto better = fitter_.roughly(picture_, guess, darker, noise_);
  return better ? fitter_.fit(bgr, *better, 0.14, darker, noise_) : std::nullopt;
}

void BodySearch::look(const cv::Mat& bgr, double min_r_px, double max_r_px, double min_votes, std::size_t patience,
                      std::vector<Candidate>& candidates) {
  for (const bool darker : {true, false}) {
    circle_votes_.clear();
    votes_.find(min_r_px / picture_.block, max_r_px / picture_.block, darker, min_votes, circle_votes_);
    // Strongest first; a long run of candidates that are nothing ends it, or many in all, as in print. What lies inside
    // a robot is no other robot.
    Places robots(2 * max_r_px, bgr.cols, bgr.rows);
    std::size_t in_vain = 0, others = 0, likely = 0;
    for (const CircleVote& vote : circle_votes_) {
      const Circle guess{picture_.picture_x(vote.x), picture_.picture_y(vote.y), vote.r * picture_.block};
      if (robots.taken(guess, 0.9 * min_r_px)) continue;
      if (++in_vain > patience || others > most_others + others_to_each * likely) break;
      ++others;
      const auto circle_fit = closely(bgr, guess, darker);
      if (!circle_fit) {
        object(guess, 0.01 * static_cast<double>(vote.votes), "too few edges lie on one circle");
        continue;
      }
      if (circle_fit->circle.r_px < min_r_px * 0.85 || circle_fit->circle.r_px > max_r_px * 1.15) continue;
      const Candidate one = candidate(*circle_fit);
      if (one.evidence <= 0) {
        const Judgement alone = judgement(one, {.r_px = circle_fit->circle.r_px, .darker = darker}, 1);
        object(circle_fit->circle, 0.02 * alone.confidence, alone.objection);
        continue;
      }
      candidates.push_back(one);
      if (one.evidence > 0.4) in_vain = 0;
      if (one.evidence <= 0.8) continue;
      robots.add(one.circle_fit.circle);
      ++likely, --others;
    }
  }
}

void BodySearch::take(const cv::Mat& bgr, int block) {
  if (std::exchange(taken_block_, block) == block) return;
  picture_.take(bgr, 0, 0, bgr.cols, bgr.rows, block);
  votes_.look_at(picture_, min_step());
}

std::vector<SizeEvidence> BodySearch::find_sizes(const cv::Mat& bgr) {
  std::vector<Candidate> candidates;
  for (int block = 1; block <= 64; block *= 2) {
    // radii from 5 to 10 pixels of the downsampled image
    if (10.0 * block < settings_.smallest_diameter_px / 2) continue;
    if (5.0 * block > settings_.largest_diameter_px / 2) break;
    take(bgr, block);
    look(bgr, 5.0 * block, 7.1 * block, 0.3, 120, candidates);
    look(bgr, 7.1 * block, 10.0 * block, 0.3, 120, candidates);
  }
  std::erase_if(candidates, [&](const Candidate& one) {
    return 2 * one.circle_fit.circle.r_px < settings_.smallest_diameter_px ||
           2 * one.circle_fit.circle.r_px > settings_.largest_diameter_px;
  });
  for (Candidate& one : candidates) one.evidence *= one.clear;
  std::vector<SizeEvidence> sizes = size_evidence(std::move(candidates), bgr.cols, bgr.rows);
  if (explanation_) explanation_->sizes = sizes;
  return sizes;
}

std::vector<Candidate> BodySearch::bodies_or_cells(const cv::Mat& bgr, double diameter_px) {
  std::vector<Candidate> robots = about_diameter(bgr, diameter_px);
  // Where most are brighter than what is round them, or have a dark ring, coin cells may have been taken for robots:
  // they were, where bodies are round most of them.
  const auto cells = std::count_if(robots.begin(), robots.end(), [&](const Candidate& one) {
    return !one.circle_fit.darker || in_dark_ring(one.circle_fit.circle);
  });
  if (!robots.empty() && cells * 10 >= static_cast<std::ptrdiff_t>(robots.size()) * 6) {
    double r_px = median_r_px(robots) / usual_cell;
    for (int turn = 0; turn < 4; ++turn) {
      std::vector<Candidate> bodies = about_diameter(bgr, 2 * r_px);
      const auto inside = std::count_if(robots.begin(), robots.end(), [&](const Candidate& cell) {
        return std::any_of(bodies.begin(), bodies.end(), [&](const Candidate& body) {
          return std::hypot(body.circle_fit.circle.x_px - cell.circle_fit.circle.x_px,
                            body.circle_fit.circle.y_px - cell.circle_fit.circle.y_px) <
                 0.4 * body.circle_fit.circle.r_px;
        });
      });
      if (inside * 2 < static_cast<std::ptrdiff_t>(robots.size())) break;
      robots = std::move(bodies);
      if (explanation_) explanation_->cells_first = true;
      const double before_px = std::exchange(r_px, median_r_px(robots));
      if (std::abs(r_px / before_px - 1) < 0.01) break;
    }
  }
  if (median_r_px(robots) > max_single_px / 2 && robots.size() < 2) robots.clear();
  return robots;
}

double BodySearch::median_r_px(const std::vector<Candidate>& robots) {
  std::vector<double> radii;
  for (const Candidate& one : robots) radii.push_back(one.circle_fit.circle.r_px);
  return median(std::move(radii));
}

bool BodySearch::in_dark_ring(const Circle& circle) const {
  const auto grey = [&](double from, double to, double part) {
    std::vector<double> values;
    for (int i = 0; i < 72; ++i) {
      const double far = circle.r_px * (from + (to - from) * (i % 3) / 2), angle = i * std::numbers::pi / 36;
      const double x = picture_.image_x(circle.x_px + far * std::cos(angle)),
                   y = picture_.image_y(circle.y_px + far * std::sin(angle));
      if (x >= 0 && y >= 0 && x <= picture_.width - 1.001 && y <= picture_.height - 1.001)
        values.push_back(static_cast<double>(picture_.at(static_cast<float>(x), static_cast<float>(y))));
    }
    std::sort(values.begin(), values.end());
    return values.empty() ? 0 : values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
  };
  const double ring = grey(1.08, 1.38, 0.5), outside = grey(1.7, 2.0, 0.5), disc = grey(0.2, 0.8, 0.5),
               black = grey(0.2, 1.38, 0.1);
  return ring < 0.6 * outside || (ring < 0.55 * disc && ring < 0.8 * outside) ||
         (outside > 1.2 * black + 8 && ring - black < 0.35 * (outside - black));
}

std::vector<Candidate> BodySearch::about_diameter(const cv::Mat& bgr, double diameter_px) {
  std::vector<std::vector<Candidate>> all;
  for (const double part : {0.95, 1.05}) all.push_back(at_diameter(bgr, part * diameter_px));
  if (all[0].empty() && all[1].empty()) return {};  // two of three must see each
  all.push_back(at_diameter(bgr, diameter_px));
  std::vector<Candidate> robots = united(bgr, all);
  std::erase_if(robots, [&](const Candidate& one) {
    const Circle& at = one.circle_fit.circle;
    const auto sees = [&](const Candidate& other) {
      return std::hypot(other.circle_fit.circle.x_px - at.x_px, other.circle_fit.circle.y_px - at.y_px) < 0.5 * at.r_px;
    };
    if (2 <= std::ranges::count_if(all, [&](const auto& some) { return std::ranges::any_of(some, sees); }))
      return false;
    object(at, one.evidence, "found at only one of three neighbouring sizes");
    return true;
  });
  return robots;
}

std::vector<Candidate> BodySearch::united(const cv::Mat& bgr, const std::vector<std::vector<Candidate>>& all) {
  std::vector<Candidate> robots;
  for (const auto& some : all) robots.insert(robots.end(), some.begin(), some.end());
  if (robots.empty()) return robots;  // of no size, for which each pixel would be a place of its own
  const double apart_px = 1.5 * median_r_px(robots);
  std::sort(robots.begin(), robots.end());
  Places places(apart_px, bgr.cols, bgr.rows);
  std::erase_if(robots, [&](const Candidate& one) {
    if (places.taken(one.circle_fit.circle, apart_px)) return true;
    places.add(one.circle_fit.circle);
    return false;
  });
  return robots;
}

std::vector<Candidate> BodySearch::at_diameter(const cv::Mat& bgr, double diameter_px) {
  const double r_px = diameter_px / 2;
  const int block = std::max(1, static_cast<int>(std::lround(r_px / 7.5)));
  take(bgr, block);
  std::vector<Candidate> candidates;
  look(bgr, r_px * (1 - settings_.diameter_tolerance * 0.75), r_px * (1 + settings_.diameter_tolerance * 0.75), 0.5, 60,
       candidates);
  const double tolerance = settings_.diameter_tolerance;
  const Likeness common = likeness(candidates, r_px, tolerance);
  // Where robots are, one at least is beyond doubt, by itself and among the others: else it is a view of clutter.
  double clearest = 0;
  std::vector<Judgement> judgements;
  for (Candidate& one : candidates) {
    judgements.push_back(judgement(one, common, tolerance));
    clearest = std::max(clearest, std::min(judgements.back().confidence, one.clear * one.evidence));
    one.evidence = judgements.back().confidence;
  }
  const bool clutter = clearest < std::max(0.65, settings_.min_confidence);
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (clutter || candidates[i].evidence < settings_.min_confidence)
      object(candidates[i].circle_fit.circle, candidates[i].evidence,
             candidates[i].evidence < settings_.min_confidence ? judgements[i].objection
                                                               : "nothing in the picture is certainly a robot");
  if (clutter) return {};
  std::erase_if(candidates, [&](const Candidate& one) { return one.evidence < settings_.min_confidence; });
  return united(bgr, {candidates});
}

void BodySearch::object(const Circle& circle, double confidence, const char* objection) {
  if (explanation_) explanation_->not_found.push_back({circle, confidence, objection});
}

double BodySearch::min_step() const {
  return std::max(4.0, 1.2 * noise_ / picture_.block);
}

}  // namespace arkmesh::tracker
