// See candidate.hpp.
#include "tracker/detect/candidate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tracker/detect/median.hpp"

namespace arkmesh::tracker {
namespace {

// Circles of different robots have their centres at least this part of a radius apart; touching ones, two radii.
constexpr double min_apart = 1.5;

double ramp(double value, double none, double all) {
  return std::clamp((value - none) / (all - none), 0.0, 1.0);
}

// Whether what is inside differs from the outside, and varies, as a robot does. Flat discs are not ruled out: a coin
// cell may be plain.
double looks(double weber, double activity) {
  return ramp(weber, 0.03, 0.2) * (0.6 + 0.4 * ramp(activity, 0.02, 0.07));
}

// Whether it has a board like a robot's: motley with parts, dark gaps between them; and something on it, not the arena
// itself as a ring has.
double likeness_of(const RadialProfile& profile, double outside) {
  const double coin = static_cast<double>(profile.coin), board = static_cast<double>(profile.board),
               low = static_cast<double>(profile.board_low);
  // in parts of the brightness here, which a coin cell that mirrors a lamp exceeds; what is nowhere dark is seen
  // through haze
  const double range = std::max(std::max({outside, std::min(coin, 1.3 * outside), board}) - 0.7 * low, 15.0);
  const double motley = ramp((static_cast<double>(profile.board_high) - low) / range, 0.06, 0.18);
  const double gaps = ramp((board - low) / range, 0.01, 0.05);
  const double solid =
      std::max({ramp((coin - board) / range, 0.8, 0.6), ramp(std::abs(coin - outside) / range, 0.1, 0.25),
                ramp(static_cast<double>(profile.coin_spread) / range, 0.1, 0.25)});
  return motley * gaps * solid;
}

// A robot among robots may be less like one than what shows that there are robots at all.
double tolerated(double likeness) {
  return std::min(1.0, 2 * likeness);
}

// How much one candidate says about the size of all: clutter is plentiful but weak and open, and small circles are
// easily imagined.
double vote(const Candidate& one) {
  const double squared = one.evidence * one.evidence;
  return static_cast<double>(one.circle_fit.closed) * squared * squared * squared *
         std::min(1.0, one.circle_fit.circle.r_px / 8);
}

}  // namespace

bool Candidate::operator<(const Candidate& other) const {
  if (evidence != other.evidence) return evidence > other.evidence;
  if (circle_fit.support != other.circle_fit.support) return circle_fit.support > other.circle_fit.support;
  return circle_fit.circle.y_px != other.circle_fit.circle.y_px ? circle_fit.circle.y_px < other.circle_fit.circle.y_px
                                                                : circle_fit.circle.x_px < other.circle_fit.circle.x_px;
}

Candidate candidate(const CircleFit& circle_fit) {
  const double outside = (circle_fit.profile.rings[11] + circle_fit.profile.rings[12]) / 2,
               board = circle_fit.profile.rings[8];
  Candidate one{circle_fit, circle_fit.contrast / std::max({outside, board, 25.0})};
  const double step = std::abs(outside - (circle_fit.profile.rings[3] + circle_fit.profile.rings[6] + board) / 3);
  // A blown out cell is plain, but not the robot.
  const double coin = static_cast<double>(circle_fit.profile.coin),
               shines = coin > 1.08 * outside ? std::max(0.0, coin - static_cast<double>(circle_fit.profile.board)) : 0;
  one.activity = std::max(static_cast<double>(circle_fit.profile.activity), 0.25 * shines) / std::max(step, 1.0);
  one.shape =
      ramp(circle_fit.support, 0.4, 0.75) * ramp(circle_fit.closed, 0.05, 0.28) * ramp(circle_fit.inside, 0.3, 0.6);
  one.likeness = likeness_of(circle_fit.profile, outside);
  // Things on a picture are round by chance, too; then the step over the edge is small beside what varies outside it
  // anyway.
  one.clear =
      ramp(circle_fit.contrast /
               std::max(static_cast<double>(circle_fit.profile.outside_high - circle_fit.profile.outside_low), 8.0),
           0.15, 0.45);
  one.clear *= one.likeness;
  // Only on dark arenas are robots brighter than what surrounds them, down to their gaps.
  const double brightest = std::max(
      {outside, static_cast<double>(circle_fit.profile.coin), static_cast<double>(circle_fit.profile.board), 15.0});
  const double low = static_cast<double>(circle_fit.profile.board_low);
  one.clear *= std::max(ramp((low - outside) / brightest, 0.25, 0.1), ramp(outside / brightest, 0.75, 0.6));
  one.evidence = one.shape * looks(one.weber, one.activity) * tolerated(one.likeness);
  return one;
}

std::vector<SizeEvidence> size_evidence(std::vector<Candidate> candidates, int width_px, int height_px) {
  std::sort(candidates.begin(), candidates.end());
  std::vector<SizeEvidence> groups;
  for (std::size_t i = 0; i < std::min<std::size_t>(candidates.size(), 150); ++i) {
    // Only strong candidates can name a size.
    const double r_px = candidates[i].circle_fit.circle.r_px;
    if (candidates[i].evidence < 0.4) break;
    if (std::any_of(groups.begin(), groups.end(),
                    [&](const SizeEvidence& group) { return std::abs(group.r_px / r_px - 1) < 0.02; }))
      continue;
    Places places(min_apart * r_px, width_px, height_px);
    std::vector<double> radii;
    SizeEvidence group{r_px, 0};
    for (const Candidate& one : candidates) {
      if (std::abs(std::log(one.circle_fit.circle.r_px / r_px)) > 0.12 ||
          places.taken(one.circle_fit.circle, min_apart * r_px))
        continue;
      places.add(one.circle_fit.circle);
      group.votes += vote(one);
      if (one.evidence > 0.5) radii.push_back(one.circle_fit.circle.r_px);
    }
    if (radii.empty()) continue;
    group.r_px = median(radii);
    groups.push_back(group);
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const SizeEvidence& a, const SizeEvidence& b) { return a.votes > b.votes; });
  // A coin cell's edge may be as clear as the board's: the board is the one outside.
  for (std::size_t i = 1; i < groups.size(); ++i)
    if (groups[i].r_px > 1.2 * groups[0].r_px && groups[i].r_px < 1.7 * groups[0].r_px &&
        groups[i].votes > 0.6 * groups[0].votes)
      std::swap(groups[0], groups[i]);
  return groups;
}

std::vector<SizeEvidence> size_evidence(std::vector<NetFind> finds, int width_px, int height_px) {
  std::stable_sort(finds.begin(), finds.end(), [](const NetFind& a, const NetFind& b) { return a.score > b.score; });
  std::vector<SizeEvidence> groups;
  for (const NetFind& first : finds) {
    // Only strong finds can name a size.
    const double r_px = first.circle.r_px;
    if (first.score < 0.4 || groups.size() > 60) break;
    if (std::ranges::any_of(groups, [&](const SizeEvidence& group) { return std::abs(group.r_px / r_px - 1) < 0.04; }))
      continue;
    Places places(min_apart * r_px, width_px, height_px);
    std::vector<double> radii;
    SizeEvidence group{r_px, 0};
    for (const NetFind& one : finds) {
      if (std::abs(std::log(one.circle.r_px / r_px)) > 0.18 || places.taken(one.circle, min_apart * r_px)) continue;
      places.add(one.circle);
      group.votes += std::pow(one.score, 4);
      if (one.score > 0.4) radii.push_back(one.circle.r_px);
    }
    group.r_px = median(radii);
    group.votes *= std::min(1.0, r_px / 8);
    if (std::ranges::none_of(groups,
                             [&](const SizeEvidence& other) { return std::abs(other.r_px / group.r_px - 1) < 0.1; }))
      groups.push_back(group);
  }
  std::ranges::stable_sort(groups, [](const SizeEvidence& a, const SizeEvidence& b) { return a.votes > b.votes; });
  return groups;
}

Likeness likeness(const std::vector<Candidate>& candidates, double r_px, double tolerance) {
  std::vector<const Candidate*> strong;
  double dark = 0, bright = 0;
  for (const Candidate& one : candidates) {
    if (one.evidence < 0.5 || std::abs(one.circle_fit.circle.r_px / r_px - 1) > tolerance) continue;
    (one.circle_fit.darker ? dark : bright) += one.evidence * one.evidence;
    strong.push_back(&one);
  }
  Likeness common{.r_px = r_px, .weber = 0, .darker = dark >= bright};
  std::erase_if(strong, [&](const Candidate* one) { return one->circle_fit.darker != common.darker; });
  if (strong.empty()) return common;
  std::vector<double> webers, activities, radii;
  for (const Candidate* one : strong)
    webers.push_back(one->weber), activities.push_back(one->activity), radii.push_back(one->circle_fit.circle.r_px);
  common.weber = median(webers);
  common.activity = median(activities);
  common.r_px = median(radii);
  if (strong.size() < 8) return common;

  // A plane through the radii: weighted least squares round the middle of the view, letting go of what lies off.
  double middle_x = 0, middle_y = 0;
  for (const Candidate* one : strong) middle_x += one->circle_fit.circle.x_px, middle_y += one->circle_fit.circle.y_px;
  middle_x /= static_cast<double>(strong.size()), middle_y /= static_cast<double>(strong.size());
  double r0 = common.r_px, per_x = 0, per_y = 0;
  for (int turn = 0; turn < 4; ++turn) {
    double s0 = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0, b0 = 0, bx = 0, by = 0;
    for (const Candidate* one : strong) {
      const double x = one->circle_fit.circle.x_px - middle_x, y = one->circle_fit.circle.y_px - middle_y;
      const double off = one->circle_fit.circle.r_px - (r0 + per_x * x + per_y * y), part = off / (0.15 * common.r_px);
      if (part * part >= 1) continue;
      const double weight = (1 - part * part) * (1 - part * part);
      s0 += weight, sx += weight * x, sy += weight * y, sxx += weight * x * x, sxy += weight * x * y,
          syy += weight * y * y;
      b0 += weight * off, bx += weight * off * x, by += weight * off * y;
    }
    // Stiff against tilting: as if robots of the mean size stood far out on all sides.
    const double far = 20 * common.r_px;
    sxx += 2 * far * far, syy += 2 * far * far;
    const double det = s0 * (sxx * syy - sxy * sxy) - sx * (sx * syy - sxy * sy) + sy * (sx * sxy - sxx * sy);
    if (!(det > 1e-6)) break;
    r0 += (b0 * (sxx * syy - sxy * sxy) - sx * (bx * syy - sxy * by) + sy * (bx * sxy - sxx * by)) / det;
    per_x += (s0 * (bx * syy - sxy * by) - b0 * (sx * syy - sxy * sy) + sy * (sx * by - bx * sy)) / det;
    per_y += (s0 * (sxx * by - bx * sxy) - sx * (sx * by - bx * sy) + b0 * (sx * sxy - sxx * sy)) / det;
  }
  common.r_px = r0 - per_x * middle_x - per_y * middle_y;
  common.r_per_x = per_x, common.r_per_y = per_y;
  return common;
}

Judgement judgement(const Candidate& candidate, const Likeness& others, double tolerance) {
  const Circle& circle = candidate.circle_fit.circle;
  const double off = std::abs(circle.r_px / std::max(others.r_at(circle.x_px, circle.y_px), 1.0) - 1);
  const std::pair<double, const char*> factors[] = {
      {candidate.shape, "the edge is no closed circle"},
      {tolerated(candidate.likeness), "the inside does not look like a board around a coin cell"},
      // A weak edge among weak edges is as good as a strong one among strong ones.
      {std::max(looks(candidate.weber, candidate.activity), looks(others.weber, others.activity)),
       "hardly differs from its surroundings"},
      {ramp(off, tolerance, tolerance / 2), "not as large as the others"},
      {others.weber > 0 ? ramp(candidate.weber / others.weber, 0.3, 0.6) : 1,
       "the edge is weaker than those of other robots"},
      {others.activity > 0 ? ramp(candidate.activity / others.activity, 0.15, 0.4) : 1, "plainer than the others"},
      {candidate.circle_fit.darker == others.darker ? 1 : 0.6,
       "dark where the other robots are bright, or bright where they are dark"}};
  Judgement all{1, factors[0].second};
  for (double least = 1; const auto& [value, objection] : factors) {
    all.confidence *= value;
    if (value < least) least = value, all.objection = objection;
  }
  return all;
}

double confidence(const Candidate& candidate, const Likeness& others, double tolerance, const NetFind& find) {
  const Circle& circle = candidate.circle_fit.circle;
  const double judged = others.weber > 0 ? judgement(candidate, others, tolerance).confidence : candidate.evidence;
  const auto squared = [](double off) { return std::min(off * off, 0.1); };
  const double from_others = std::log(circle.r_px / std::max(others.r_at(circle.x_px, circle.y_px), 1.0));
  const double from_net = std::max(0.0, std::abs(std::log(circle.r_px / find.circle.r_px)) - 0.1);
  const double score = std::min(find.score, 0.995);
  // A logistic regression on what edges or the net proposed in 60 rendered rooms (30 to 59, plain and strange) and on
  // the bench's changed real pictures, at right and wrong sizes.
  const double odds = 0.88 * std::log(score / (1 - score)) + 2.2 * (candidate.evidence + judged) +
                      2.96 * candidate.likeness - 195 * (squared(from_others) + squared(from_net)) - 3.2;
  return 1 / (1 + std::exp(-odds));
}

Places::Places(double cell_px, int width_px, int height_px)
    : cell_px_(std::max(cell_px, 1.0)),
      wide_(static_cast<int>(width_px / cell_px_) + 3),
      high_(static_cast<int>(height_px / cell_px_) + 3),
      cells_(static_cast<std::size_t>(wide_) * static_cast<std::size_t>(high_)) {}

void Places::add(const Circle& circle) {
  cells_[cell(column(circle.x_px), line(circle.y_px))].push_back(circle);
}

bool Places::taken(const Circle& circle, double min_px) const {
  const int x = column(circle.x_px), y = line(circle.y_px);
  for (int cy = std::max(0, y - 1); cy <= std::min(high_ - 1, y + 1); ++cy)
    for (int cx = std::max(0, x - 1); cx <= std::min(wide_ - 1, x + 1); ++cx)
      for (const Circle& other : cells_[cell(cx, cy)])
        if (std::hypot(other.x_px - circle.x_px, other.y_px - circle.y_px) < min_px) return true;
  return false;
}

int Places::column(double x_px) const {
  return std::clamp(static_cast<int>(x_px / cell_px_) + 1, 0, wide_ - 1);
}
int Places::line(double y_px) const {
  return std::clamp(static_cast<int>(y_px / cell_px_) + 1, 0, high_ - 1);
}
std::size_t Places::cell(int x, int y) const {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(wide_) + static_cast<std::size_t>(x);
}

}  // namespace arkmesh::tracker
