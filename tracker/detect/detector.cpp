// See detector.hpp.
#include "tracker/detect/detector.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>

#include "tracker/detect/body_search.hpp"
#include "tracker/detect/candidate.hpp"
#include "tracker/detect/led_neighbours.hpp"
#include "tracker/detect/led_spot.hpp"
#include "tracker/detect/levels.hpp"
#include "tracker/detect/median.hpp"
#include "tracker/detect/robot_search.hpp"
#include "tracker/detect/white_balance.hpp"

namespace arkmesh::tracker {

namespace {

constexpr int whole_every = 6;  // searches of a camera in which nothing has changed

}  // namespace

class Detector::Search {
 public:
  explicit Search(const DetectorSettings& settings)
      : settings_(settings), diameter_px_(settings.diameter_px), bodies_(settings) {}

  // A picture of few grey levels is searched with its contrast stretched. If that shows fewer than three robots, the
  // original is searched, too, and the few are believed if it shows none. LEDs are read in the original.
  std::vector<Detection> search(const cv::Mat& bgr) {
    const Levels levels = levels_of(bgr);
    bool few = false;
    if (levels.gain > 1 && (levels_.gain > 1 || before_.size() < enough_robots)) {
      if (levels_.gain == 1) before_.clear();
      const std::optional<double> diameter_px = diameter_px_;
      levels_ = levels;
      const std::vector<Candidate> robots = look(stretched(bgr, levels));
      if (robots.size() >= enough_robots) return with_leds(bgr, robots);
      few = !robots.empty();
      diameter_px_ = diameter_px;
    }
    if (std::exchange(levels_, {}).gain > 1) before_.clear();
    std::vector<Candidate> robots = look(bgr);
    if (few && robots.empty()) levels_ = levels, robots = look(stretched(bgr, levels));
    return with_leds(bgr, robots);
  }

  std::vector<Candidate> look(const cv::Mat& bgr) {
    bodies_.begin(noise_of(bgr));
    std::vector<Candidate> robots = unchanged(bgr);
    if (robots.empty()) robots = searched(bgr);
    before_.clear();
    for (const Candidate& one : robots) before_.push_back(one.circle_fit.circle);
    // Three that agree are worth remembering; cameras are refocused and arenas tilted, so it drifts along.
    if (!settings_.diameter_px) {
      const double found_px = 2 * BodySearch::median_r_px(robots);
      if (robots.size() < enough_robots)
        diameter_px_.reset();
      else if (diameter_px_ && std::abs(found_px / *diameter_px_ - 1) < 0.5 * settings_.diameter_tolerance)
        *diameter_px_ += 0.3 * (found_px - *diameter_px_);
      else
        diameter_px_ = found_px;
    }
    return robots;
  }

  std::vector<std::optional<Detection>> follow(const cv::Mat& bgr, std::span<const Expected> where) {
    const cv::Mat bodies = levels_.gain > 1 ? stretched(bgr, levels_) : bgr;
    std::vector<std::optional<Detection>> seen(where.size());
    // Searches keep it up to date.
    if (bodies_.noise() == 0) bodies_.begin(noise_of(bodies));
    std::vector<Claim> claims;
    claims.reserve(where.size());
    for (std::size_t i = 0; i < where.size(); ++i) {
      if (i + 1 < where.size()) fetch_ahead(bodies, where[i + 1]);
      // Its LED is looked at while its pixels are at hand.
      if (const auto one = bodies_.near(bodies, where[i]))
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
    bodies_.explain(&explanation);
    before_.clear();
    std::vector<Detection> robots = search(bgr);
    bodies_.explain(nullptr);
    thin_out(explanation, robots);
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

  // While nothing changes, one size is enough, and the search net is not asked: as many robots as before, each where
  // one was. Else nothing.
  std::vector<Candidate> unchanged(const cv::Mat& bgr) {
    if (before_.size() < 3 || ++since_whole_ >= whole_every) return {};
    std::vector<double> radii;
    for (const Circle& one : before_) radii.push_back(one.r_px);
    const double diameter_px = 2 * median(std::move(radii)), near_px = 0.75 * diameter_px;
    std::vector<Candidate> robots = bodies_.at_diameter(bgr, diameter_px);
    Places places(near_px, bgr.cols, bgr.rows), refused(near_px, bgr.cols, bgr.rows);
    for (const Circle& one : before_) places.add(one);
    for (const Circle& one : search_.refused()) refused.add(one);
    std::erase_if(robots, [&](const Candidate& one) { return refused.taken(one.circle_fit.circle, near_px / 3); });
    // What only the nets had seen: edges, or a close look, may show it where it was.
    if (robots.size() < before_.size()) {
      Places found(near_px, bgr.cols, bgr.rows);
      for (const Candidate& one : robots) found.add(one.circle_fit.circle);
      for (const Circle& one : before_) {
        if (found.taken(one, near_px)) continue;
        auto fit = bodies_.fit(bgr, one, 0.1, true);
        if (!fit) fit = bodies_.fit(bgr, one, 0.1, false);
        Candidate robot = candidate(fit.value_or(CircleFit{.circle = one}));
        const double least = settings_.min_confidence;
        if (robot.evidence < least) robot.evidence = search_.look_closely(bgr, robot.circle_fit.circle);
        if (robot.evidence < least) return {};
        robots.push_back(robot);
      }
    }
    const bool same = robots.size() == before_.size() && std::ranges::all_of(robots, [&](const Candidate& one) {
                        return places.taken(one.circle_fit.circle, near_px);
                      });
    return same ? robots : std::vector<Candidate>{};
  }

  std::vector<Candidate> searched(const cv::Mat& bgr) {
    since_whole_ = 0;
    search_.look_at(bgr);
    if (!settings_.diameter_px) return search_.of_any_size(diameter_px_);
    if (!settings_.diameter_told) return search_.about_diameter(*settings_.diameter_px);
    // A person's figure may be a little wrong: it decides where the search begins and which sizes are impossible.
    std::vector<Candidate> robots = search_.of_any_size(*settings_.diameter_px);
    std::erase_if(robots, [&](const Candidate& one) {
      return std::abs(2 * one.circle_fit.circle.r_px / *settings_.diameter_px - 1) > 1.5 * settings_.diameter_tolerance;
    });
    return robots.empty() ? search_.about_diameter(*settings_.diameter_px) : robots;
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

  Detection detection(const cv::Mat& bgr, const Candidate& one) const {
    const Circle& circle = one.circle_fit.circle;
    const LedSpot led = find_led(bgr, circle, white_balance_);
    return {circle.x_px, circle.y_px,    circle.r_px,        static_cast<float>(one.evidence),
            led.led,     led.confidence, led.lit_confidence, led.hue_deg,
            led.x_px,    led.y_px,       led.primary,        led.primary_confidence};
  }

  DetectorSettings settings_;
  std::optional<double> diameter_px_;
  Light white_balance_{1, 1, 1};  // of the picture last searched
  bool monochrome_ = false;       // likewise
  Levels levels_;                 // with which its bodies were looked for
  BodySearch bodies_;
  RobotSearch search_{settings_, bodies_};
  std::vector<Circle> before_;  // what the last search found
  int since_whole_ = 0;         // searches
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
