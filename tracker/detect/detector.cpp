// See detector.hpp.
#include "tracker/detect/detector.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>

#include "tracker/detect/candidate.hpp"
#include "tracker/detect/led_neighbours.hpp"
#include "tracker/detect/led_spot.hpp"
#include "tracker/detect/median.hpp"
#include "tracker/detect/round_votes.hpp"
#include "tracker/detect/search_net.hpp"
#include "tracker/detect/white_balance.hpp"

namespace arkmesh::tracker {

namespace {

constexpr double max_single_px = 128;       // a single circle that is larger is more often something else than a robot
constexpr double least_score = 0.3;         // of the net, for a closer look
constexpr double surely_seen = 0.7;         // confidence in what only the net has seen
constexpr double least_likeness = 0.5;      // of that: plain discs and rings have none
constexpr double fewest_of_own = 3;         // beyond doubt, where nothing else was found
constexpr std::size_t max_sizes = 6;        // that are looked at closely, of those that the net sees
constexpr std::size_t max_objections = 60;  // that an explanation holds

// Whether a picture has no colour where its robots are: a monochrome camera's.
bool monochrome(const cv::Mat& bgr, std::span<const Circle> boards) {
  constexpr int max_difference = 3, rows = 12;
  for (const Circle& board : boards)
    for (int i = 0; i < rows * rows; ++i) {
      const double x = board.x_px + board.r_px * (2.0 * (i % rows) / (rows - 1) - 1),
                   y = board.y_px + board.r_px * (2.0 * (i / rows) / (rows - 1) - 1);
      if (!(x >= 0 && y >= 0 && x < bgr.cols && y < bgr.rows)) continue;
      const std::uint8_t* const pixel = bgr.ptr<std::uint8_t>(static_cast<int>(y)) + 3 * static_cast<int>(x);
      const auto [least, most] = std::minmax({pixel[0], pixel[1], pixel[2]});
      if (most - least > max_difference) return false;
    }
  return !boards.empty();
}

}  // namespace

class Detector::Search {
 public:
  explicit Search(const DetectorSettings& settings) : settings_(settings), diameter_px_(settings.diameter_px) {}

  std::vector<Detection> search(const cv::Mat& bgr) {
    noise_ = noise_of(bgr);
    taken_block_ = 0;
    net_.look_at(bgr);
    std::vector<Candidate> robots;
    if (settings_.diameter_px) {
      robots = about_diameter(bgr, *settings_.diameter_px);
      if (settings_.diameter_told) {
        // Told by a person, who may be a little wrong: what is found without it counts, too.
        std::vector<Candidate> untold = with_second_opinion(bgr, of_any_diameter(bgr), true);
        std::erase_if(untold, [&](const Candidate& one) {
          return std::abs(2 * one.circle_fit.circle.r_px / *settings_.diameter_px - 1) >
                 1.5 * settings_.diameter_tolerance;
        });
        robots = united(bgr, {robots, untold});
      }
      return with_leds(bgr, with_second_opinion(bgr, std::move(robots), false));
    }
    if (diameter_px_) robots = about_diameter(bgr, *diameter_px_);
    if (robots.empty()) diameter_px_.reset(), robots = of_any_diameter(bgr);
    robots = with_second_opinion(bgr, std::move(robots), true);
    // Three that agree are worth remembering; cameras are refocused and tables tilted, so it drifts along.
    if (robots.size() < 3)
      diameter_px_.reset();
    else
      diameter_px_ =
          diameter_px_ ? *diameter_px_ + 0.3 * (2 * median_r_px(robots) - *diameter_px_) : 2 * median_r_px(robots);
    return with_leds(bgr, robots);
  }

  std::vector<std::optional<Detection>> follow(const cv::Mat& bgr, std::span<const Expected> where) {
    std::vector<std::optional<Detection>> seen(where.size());
    // Searches keep it up to date.
    if (noise_ == 0) noise_ = noise_of(bgr);
    std::vector<Claim> claims;
    claims.reserve(where.size());
    for (std::size_t i = 0; i < where.size(); ++i) {
      if (i + 1 < where.size()) fetch_ahead(bgr, where[i + 1]);
      // Its LED is looked at while its pixels are at hand.
      if (const auto one = near(bgr, where[i]))
        claims.push_back(
            {std::hypot(one->circle_fit.circle.x_px - where[i].x_px, one->circle_fit.circle.y_px - where[i].y_px), i,
             detection(bgr, *one)});
    }
    if (claims.empty()) return seen;
    // Nearest first: two places that see the same robot do not both get it.
    std::sort(claims.begin(), claims.end(), [](const Claim& a, const Claim& b) {
      return a.off_px != b.off_px ? a.off_px < b.off_px : a.place < b.place;
    });
    double largest_r_px = 1;
    for (const Claim& claim : claims) largest_r_px = std::max(largest_r_px, claim.seen.r_px);
    Places places(1.5 * largest_r_px, bgr.cols, bgr.rows);
    for (const Claim& claim : claims) {
      const Circle circle{claim.seen.x_px, claim.seen.y_px, claim.seen.r_px};
      if (places.taken(circle, 1.5 * circle.r_px)) continue;
      places.add(circle);
      seen[claim.place] = claim.seen;
    }
    std::vector<Detection*> robots;
    for (auto& one : seen)
      if (one) robots.push_back(&*one);
    judge_beside_others(robots);
    doubt_white(robots);
    if (monochrome_) std::ranges::for_each(robots, [](Detection* robot) { forget_led(*robot); });
    return seen;
  }

  std::vector<Detection> search(const cv::Mat& bgr, Explanation& explanation) {
    explanation = {};
    explanation_ = &explanation;
    std::vector<Detection> robots = search(bgr);
    explanation_ = nullptr;
    auto& others = explanation.not_found;
    std::stable_sort(others.begin(), others.end(),
                     [](const auto& a, const auto& b) { return a.confidence > b.confidence; });
    double r_px = robots.empty() ? 0 : robots[0].r_px;
    if (r_px == 0 && !explanation.sizes.empty()) r_px = explanation.sizes[0].r_px;
    std::vector<Circle> taken;
    for (const Detection& one : robots) taken.push_back({one.x_px, one.y_px, one.r_px});
    std::erase_if(others, [&](const Explanation::NotFound& one) {
      const Circle& at = one.circle;
      if (taken.size() >= robots.size() + max_objections || (r_px > 0 && std::abs(std::log(at.r_px / r_px)) > 0.25) ||
          std::any_of(taken.begin(), taken.end(), [&](const Circle& other) {
            return std::hypot(other.x_px - at.x_px, other.y_px - at.y_px) < std::max(other.r_px, at.r_px);
          }))
        return true;
      taken.push_back(at);
      return false;
    });
    return robots;
  }

  std::optional<double> diameter_px() const { return diameter_px_; }

 private:
  struct Claim {
    double off_px;
    std::size_t place;
    Detection seen;
  };

  // Asks the memory for the pixels round a place while another is looked at: a picture is larger than a processor's
  // cache.
  static void fetch_ahead(const cv::Mat& bgr, const Expected& place) {
    const double far_px = 1.45 * place.r_px + 3;
    if (!(far_px < 1000 && std::abs(place.x_px) < 1e6 && std::abs(place.y_px) < 1e6)) return;
    const auto inside = [](double at, int size) {
      return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(size)));
    };
    const int left = inside(place.x_px - far_px, bgr.cols), right = inside(place.x_px + far_px, bgr.cols);
    constexpr int line_bytes = 64;
    for (int y = inside(place.y_px - far_px, bgr.rows), end = inside(place.y_px + far_px, bgr.rows); y < end; ++y) {
      const std::uint8_t* const row = bgr.ptr<std::uint8_t>(y);
      for (int byte = 3 * left; byte < 3 * right + line_bytes; byte += line_bytes)
        __builtin_prefetch(row + std::min(byte, 3 * right));
    }
  }

  // The robot nearest to an expected place, if one is within its reach.
  std::optional<Candidate> near(const cv::Mat& bgr, const Expected& place) {
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

  // First on the shrunk picture, where most of what is no robot shows itself; then on the picture itself.
  std::optional<CircleFit> closely(const cv::Mat& bgr, const Circle& guess, bool darker) {
    const auto better = fitter_.roughly(picture_, guess, darker, noise_);
    return better ? fitter_.fit(bgr, *better, 0.14, darker, noise_) : std::nullopt;
  }

  // Candidates of radii [least, most] px in the shrunk picture, each looked at closely, until `patience` of them in a
  // row are nothing.
  void look(const cv::Mat& bgr, double min_r_px, double max_r_px, double min_votes, std::size_t patience,
            std::vector<Candidate>& candidates) {
    for (const bool darker : {true, false}) {
      circle_votes_.clear();
      votes_.find(min_r_px / picture_.block, max_r_px / picture_.block, darker, min_votes, circle_votes_);
      // Strongest first; a long run of candidates that are nothing ends it. What lies inside a robot is no other robot.
      Places robots(2 * max_r_px, bgr.cols, bgr.rows);
      std::size_t in_vain = 0;
      for (const CircleVote& vote : circle_votes_) {
        const Circle guess{picture_.picture_x(vote.x), picture_.picture_y(vote.y), vote.r * picture_.block};
        if (robots.taken(guess, 0.9 * min_r_px)) continue;
        if (++in_vain > patience) break;
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
        if (one.evidence > 0.8) robots.add(one.circle_fit.circle);
      }
    }
  }

  // The whole picture, shrunk, unless it is so already.
  void take(const cv::Mat& bgr, int block) {
    if (std::exchange(taken_block_, block) == block) return;
    picture_.take(bgr, 0, 0, bgr.cols, bgr.rows, block);
    votes_.look_at(picture_, min_step());
  }

  std::optional<double> find_diameter(const cv::Mat& bgr) {
    std::vector<Candidate> candidates;
    for (int block = 1; block <= 64; block *= 2) {
      // radii from 5 to 10 shrunk pixels
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
    const std::vector<SizeEvidence> sizes = size_evidence(std::move(candidates), bgr.cols, bgr.rows);
    if (explanation_) explanation_->sizes = sizes;
    if (sizes.empty()) return {};
    return 2 * sizes[0].r_px;
  }

  // Of the size that has most evidence for it.
  std::vector<Candidate> of_any_diameter(const cv::Mat& bgr) {
    const auto diameter_px = find_diameter(bgr);
    if (!diameter_px) return {};
    std::vector<Candidate> robots = about_diameter(bgr, *diameter_px);
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

  static double median_r_px(const std::vector<Candidate>& robots) {
    std::vector<double> radii;
    for (const Candidate& one : robots) radii.push_back(one.circle_fit.circle.r_px);
    return median(std::move(radii));
  }

  // Whether a circle is a coin cell's: board round it, and arena round that. Grey levels of the picture looked at last.
  bool in_dark_ring(const Circle& circle) const {
    const auto grey = [&](double from, double to, double part) {
      std::vector<double> values;
      for (int i = 0; i < 72; ++i) {
        const double far = circle.r_px * (from + (to - from) * (i % 3) / 2), angle = i * std::numbers::pi / 36;
        const double x = picture_.shrunk_x(circle.x_px + far * std::cos(angle)),
                     y = picture_.shrunk_y(circle.y_px + far * std::sin(angle));
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

  // The trained net's opinion: adds robots of the others' size; where it sees less than half of what was found, or
  // nothing was found, it looks for robots of any size, if `any_size`.
  std::vector<Candidate> with_second_opinion(const cv::Mat& bgr, std::vector<Candidate> robots, bool any_size) {
    std::size_t agreed = 0;
    if (!robots.empty()) {
      const double r_px = median_r_px(robots);
      const std::vector<Candidate> seen = seen_by_net(bgr, r_px);
      agreed = static_cast<std::size_t>(std::ranges::count_if(robots, [&](const Candidate& one) {
        return std::ranges::any_of(finds_, [&](const NetFind& find) {
          return find.score > 0.5 && std::hypot(find.circle.x_px - one.circle_fit.circle.x_px,
                                                find.circle.y_px - one.circle_fit.circle.y_px) < 0.5 * r_px;
        });
      }));
      if (2 * agreed >= robots.size()) {
        // What was found already keeps its place.
        Places places(1.5 * r_px, bgr.cols, bgr.rows);
        for (const Candidate& one : robots) places.add(one.circle_fit.circle);
        for (const Candidate& one : seen)
          if (!places.taken(one.circle_fit.circle, 1.5 * r_px)) robots.push_back(one);
        std::sort(robots.begin(), robots.end());
        return robots;
      }
    }
    if (!any_size) return robots;
    finds_.clear();
    for (double r_px = settings_.smallest_diameter_px / 2; r_px < settings_.largest_diameter_px / 2;
         r_px *= std::numbers::sqrt2)
      net_.find(r_px, least_score, finds_);
    const std::vector<SizeEvidence> sizes = size_evidence(finds_, bgr.cols, bgr.rows);
    std::vector<Candidate> best;
    double most = std::max(static_cast<double>(agreed), fewest_of_own);
    for (std::size_t i = 0; i < std::min(sizes.size(), max_sizes); ++i) {
      std::vector<Candidate> some = seen_by_net(bgr, sizes[i].r_px);
      if (some.empty()) continue;
      // Again at the size that the edges have.
      some = seen_by_net(bgr, median_r_px(some));
      double votes = 0;
      for (const Candidate& one : some)
        votes += std::pow(one.evidence, 4) * std::min(1.0, one.circle_fit.circle.r_px / 8);
      if (votes > most) most = votes, best = std::move(some);
    }
    return best.empty() ? robots : best;
  }

  // Robots of that size which the net sees and whose edge can be measured; what the net sees is in finds_.
  std::vector<Candidate> seen_by_net(const cv::Mat& bgr, double r_px) {
    finds_.clear();
    net_.find(r_px, least_score, finds_);
    std::vector<Candidate> seen;
    for (const NetFind& find : finds_) {
      std::optional<Candidate> best;
      for (const double r : {find.circle.r_px, r_px})
        for (const bool darker : {true, false})
          if (const auto circle_fit =
                  fitter_.fit(bgr, {find.circle.x_px, find.circle.y_px, r}, r == r_px ? 0.14 : 0.22, darker, noise_)) {
            Candidate one = candidate(*circle_fit);
            one.evidence = confidence(one, find.score, r_px);
            if (!best || one.evidence > best->evidence) best = one;
          }
      if (best && best->evidence > surely_seen && best->likeness > least_likeness && best->circle_fit.inside > 0.6F)
        seen.push_back(*best);
    }
    return united(bgr, {seen});
  }

  // Searches at neighbouring sizes together: near a limit each alone may miss a robot, and what only one finds is
  // mostly none.
  std::vector<Candidate> about_diameter(const cv::Mat& bgr, double diameter_px) {
    std::vector<std::vector<Candidate>> all;
    for (const double part : {0.95, 1.05, 1.0}) all.push_back(at_diameter(bgr, part * diameter_px));
    std::vector<Candidate> robots = united(bgr, all);
    std::erase_if(robots, [&](const Candidate& one) {
      const Circle& at = one.circle_fit.circle;
      const auto sees = [&](const Candidate& other) {
        return std::hypot(other.circle_fit.circle.x_px - at.x_px, other.circle_fit.circle.y_px - at.y_px) <
               0.5 * at.r_px;
      };
      if (2 <= std::ranges::count_if(all, [&](const auto& some) { return std::ranges::any_of(some, sees); }))
        return false;
      object(at, one.evidence, "found at one of three neighbouring sizes only");
      return true;
    });
    return robots;
  }

  // The surest first; no two overlap by more than robots can.
  static std::vector<Candidate> united(const cv::Mat& bgr, const std::vector<std::vector<Candidate>>& all) {
    std::vector<Candidate> robots;
    for (const auto& some : all) robots.insert(robots.end(), some.begin(), some.end());
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

  std::vector<Candidate> at_diameter(const cv::Mat& bgr, double diameter_px) {
    const double r_px = diameter_px / 2;
    const int block = std::max(1, static_cast<int>(std::lround(r_px / 7.5)));
    take(bgr, block);
    std::vector<Candidate> candidates;
    look(bgr, r_px * (1 - settings_.diameter_tolerance * 0.75), r_px * (1 + settings_.diameter_tolerance * 0.75), 0.5,
         60, candidates);
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
                                                                 : "nothing in the picture is a robot beyond doubt");
    if (clutter) return {};
    std::erase_if(candidates, [&](const Candidate& one) { return one.evidence < settings_.min_confidence; });
    return united(bgr, {candidates});
  }

  std::vector<Detection> with_leds(const cv::Mat& bgr, const std::vector<Candidate>& candidates) {
    std::vector<Circle> boards;
    for (const Candidate& one : candidates) boards.push_back(one.circle_fit.circle);
    white_balance_ = white_balance(bgr, boards);
    std::vector<Detection> found;
    for (const Candidate& one : candidates) found.push_back(detection(bgr, one));
    std::vector<Detection*> robots;
    for (Detection& one : found) robots.push_back(&one);
    judge_beside_others(robots);
    doubt_white(robots);
    monochrome_ = monochrome(bgr, boards);
    if (monochrome_) std::ranges::for_each(robots, [](Detection* robot) { forget_led(*robot); });
    return found;
  }

  void object(const Circle& circle, double confidence, const char* objection) {
    if (explanation_) explanation_->not_found.push_back({circle, confidence, objection});
  }

  // The weakest edge of the shrunk picture that may vote, in grey levels a pixel.
  double min_step() const { return std::max(4.0, 1.2 * noise_ / picture_.block); }

  Detection detection(const cv::Mat& bgr, const Candidate& one) const {
    const Circle& circle = one.circle_fit.circle;
    const LedSpot led = find_led(bgr, circle, white_balance_);
    return {circle.x_px, circle.y_px,    circle.r_px,        static_cast<float>(one.evidence),
            led.led,     led.confidence, led.lit_confidence, led.hue_deg,
            led.x_px,    led.y_px,       led.primary,        led.primary_confidence};
  }

  DetectorSettings settings_;
  std::optional<double> diameter_px_;
  double noise_ = 0;              // of the picture looked at, in grey levels
  Light white_balance_{1, 1, 1};  // of the picture last searched
  bool monochrome_ = false;       // likewise
  ShrunkPicture picture_;
  int taken_block_ = 0;  // of the whole picture in picture_ and votes_; 0: they hold something else
  RoundVotes votes_;
  CircleFitter fitter_;
  SearchNet net_;
  std::vector<NetFind> finds_;
  std::vector<CircleVote> circle_votes_;
  Explanation* explanation_ = nullptr;  // of the search that goes on, if it is wanted
};

Detector::Detector(const DetectorSettings& settings) : search_(std::make_unique<Search>(settings)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::vector<Detection> Detector::search(const cv::Mat& bgr, Explanation* explanation) {
  if (bgr.empty() || bgr.type() != CV_8UC3) throw std::invalid_argument("the detector wants 8-bit BGR pictures");
  return explanation ? search_->search(bgr, *explanation) : search_->search(bgr);
}

std::vector<std::optional<Detection>> Detector::follow(const cv::Mat& bgr, std::span<const Expected> where) {
  if (bgr.empty() || bgr.type() != CV_8UC3) throw std::invalid_argument("the detector wants 8-bit BGR pictures");
  return search_->follow(bgr, where);
}

std::optional<double> Detector::diameter_px() const {
  return search_->diameter_px();
}

}  // namespace arkmesh::tracker
