// See detector.hpp.
#include "tracker/detect/detector.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "tracker/detect/candidate.hpp"
#include "tracker/detect/led_neighbours.hpp"
#include "tracker/detect/led_spot.hpp"
#include "tracker/detect/round_votes.hpp"
#include "tracker/detect/white_balance.hpp"

namespace arkmesh::tracker {

namespace {

constexpr double max_single_px = 128;  // a single circle that is larger is more often something else than a robot

}  // namespace

class Detector::Search {
 public:
  explicit Search(const DetectorSettings& settings) : settings_(settings), diameter_px_(settings.diameter_px) {}

  std::vector<Detection> search(const cv::Mat& bgr) {
    noise_ = noise_of(bgr);
    if (settings_.diameter_px) return at_diameter(bgr, *settings_.diameter_px);
    std::vector<Detection> found;
    if (diameter_px_) found = at_diameter(bgr, *diameter_px_);
    if (found.empty()) {
      diameter_px_ = find_diameter(bgr);
      if (!diameter_px_) return {};
      found = at_diameter(bgr, *diameter_px_);
      if (*diameter_px_ > max_single_px && found.size() < 2) found.clear();
    }
    // Three that agree are worth remembering; cameras are refocused and tables tilted, so it drifts along.
    if (found.size() < 3) {
      diameter_px_.reset();
    } else {
      std::vector<double> radii;
      for (const Detection& one : found) radii.push_back(one.r_px);
      std::nth_element(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2), radii.end());
      *diameter_px_ += 0.3 * (2 * radii[radii.size() / 2] - *diameter_px_);
    }
    return found;
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
    return seen;
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
        if (!circle_fit || circle_fit->circle.r_px < min_r_px * 0.85 || circle_fit->circle.r_px > max_r_px * 1.15)
          continue;
        const Candidate one = candidate(*circle_fit);
        if (one.evidence <= 0) continue;
        candidates.push_back(one);
        if (one.evidence > 0.4) in_vain = 0;
        if (one.evidence > 0.8) robots.add(one.circle_fit.circle);
      }
    }
  }

  std::optional<double> find_diameter(const cv::Mat& bgr) {
    std::vector<Candidate> candidates;
    for (int block = 1; block <= 64; block *= 2) {
      // radii from 5 to 10 shrunk pixels
      if (10.0 * block < settings_.smallest_diameter_px / 2) continue;
      if (5.0 * block > settings_.largest_diameter_px / 2) break;
      picture_.take(bgr, 0, 0, bgr.cols, bgr.rows, block);
      votes_.look_at(picture_, min_step());
      look(bgr, 5.0 * block, 7.1 * block, 0.3, 120, candidates);
      look(bgr, 7.1 * block, 10.0 * block, 0.3, 120, candidates);
    }
    std::erase_if(candidates, [&](const Candidate& one) {
      return 2 * one.circle_fit.circle.r_px < settings_.smallest_diameter_px ||
             2 * one.circle_fit.circle.r_px > settings_.largest_diameter_px;
    });
    for (Candidate& one : candidates) one.evidence *= one.clear;
    const auto r_px = common_radius_px(std::move(candidates), bgr.cols, bgr.rows);
    if (!r_px) return {};
    return 2 * *r_px;
  }

  std::vector<Detection> at_diameter(const cv::Mat& bgr, double diameter_px) {
    const double r_px = diameter_px / 2;
    const int block = std::max(1, static_cast<int>(std::lround(r_px / 7.5)));
    picture_.take(bgr, 0, 0, bgr.cols, bgr.rows, block);
    votes_.look_at(picture_, min_step());
    std::vector<Candidate> candidates;
    look(bgr, r_px * (1 - settings_.diameter_tolerance * 0.75), r_px * (1 + settings_.diameter_tolerance * 0.75), 0.5,
         60, candidates);
    const double tolerance = settings_.diameter_tolerance;
    const Likeness common = likeness(candidates, r_px, tolerance);
    // Where robots are, one at least is beyond doubt, by itself and among the others: else it is a view of clutter.
    double clearest = 0;
    for (Candidate& one : candidates) {
      const double among = confidence(one, common, tolerance);
      clearest = std::max(clearest, std::min(among, one.clear * one.evidence));
      one.evidence = among;
    }
    std::sort(candidates.begin(), candidates.end());
    std::vector<Detection> found;
    if (clearest < std::max(0.65, settings_.min_confidence)) return found;
    Places places(1.5 * r_px, bgr.cols, bgr.rows);
    std::vector<Circle> boards;
    std::erase_if(candidates, [&](const Candidate& one) {
      const Circle& circle = one.circle_fit.circle;
      if (one.evidence < settings_.min_confidence || places.taken(circle, 1.5 * r_px)) return true;
      places.add(circle);
      boards.push_back(circle);
      return false;
    });
    white_balance_ = white_balance(bgr, boards);
    for (const Candidate& one : candidates) found.push_back(detection(bgr, one));
    std::vector<Detection*> robots;
    for (Detection& one : found) robots.push_back(&one);
    judge_beside_others(robots);
    return found;
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
  ShrunkPicture picture_;
  RoundVotes votes_;
  CircleFitter fitter_;
  std::vector<CircleVote> circle_votes_;
};

Detector::Detector(const DetectorSettings& settings) : search_(std::make_unique<Search>(settings)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::vector<Detection> Detector::search(const cv::Mat& bgr) {
  if (bgr.empty() || bgr.type() != CV_8UC3) throw std::invalid_argument("the detector wants 8-bit BGR pictures");
  return search_->search(bgr);
}

std::vector<std::optional<Detection>> Detector::follow(const cv::Mat& bgr, std::span<const Expected> where) {
  if (bgr.empty() || bgr.type() != CV_8UC3) throw std::invalid_argument("the detector wants 8-bit BGR pictures");
  return search_->follow(bgr, where);
}

std::optional<double> Detector::diameter_px() const {
  return search_->diameter_px();
}

}  // namespace arkmesh::tracker
