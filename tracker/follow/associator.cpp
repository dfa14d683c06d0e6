#include "tracker/follow/associator.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace arkmesh::tracker {
namespace {

constexpr double seen_probability = 0.98;      // of a robot that was seen in the last frame
constexpr double stranger_density = 1e-3;      // new robots and false observations, per square metre and frame
constexpr double jump_probability = 0.02;      // of being anywhere within reach, whatever the motion says
constexpr float clear_confidence = 0.65f;      // an observation this clear is a robot at once
constexpr std::uint32_t times_to_believe = 3;  // one less clear must be repeated
constexpr float settled_confidence = 0.4f;     // below it (after a gap and one weak observation) nobody acts on the id
constexpr hal::LabTime keep_led{1'000'000};    // the last certain colour, while it cannot be told
constexpr float certain_led = 0.5f;            // colours less certain than this change nothing
constexpr std::uint32_t settled_after = 10;    // observations: from then on motion is expected to be known
constexpr double noise_step = 0.01;            // a look moves what is learnt of LEDs' noise by so much of it
constexpr double min_led_noise = 0.15, max_led_noise = 4;  // in parts of the stated one
// Who is who must bear more than noise: pushes, and starts, of which the path grows with time.
constexpr double push_m = 0.0006, start_m2_s3 = 1.7e-4;
constexpr double walks_m_s = 0.002;  // who stands shows the same error again and again

double seconds(hal::LabTime t) {
  return static_cast<double>(t.count()) * 1e-6;
}

// Mean and standard deviation of three or more, of which a further one would be.
std::optional<LedOffset> usual_of(const std::map<hal::RobotId, LedOffset>& offsets) {
  if (offsets.size() < 3) return {};
  double along = 0, across = 0, squares = 0;
  for (const auto& [robot, offset] : offsets) along += std::cos(offset.rad), across += std::sin(offset.rad);
  const double mean = std::atan2(across, along), n = static_cast<double>(offsets.size());
  for (const auto& [robot, offset] : offsets) squares += std::pow(wrapped(offset.rad - mean), 2);
  return LedOffset{mean, std::sqrt(squares / (n - 1) * (1 + 1 / n))};
}

}  // namespace

Associator::Associator(const AssociatorSettings& settings) : settings_(settings) {
  assert(settings.diameter_m + settings.motion.rear_axle_m > 0 && "the caller gives the robots' measures");
  usual_led_offset_ =
      usual_of(settings_.led_offsets).value_or(LedOffset{settings_.led_offset_rad, settings_.led_offset_error_rad});
}

double Associator::reach_m(const Followed& followed, hal::LabTime now) const {
  return settings_.reach_m + settings_.top_speed_m_s * seconds(now - followed.last_seen);
}

std::vector<Prospect> Associator::prospects(hal::LabTime now) const {
  std::vector<Prospect> all;
  all.reserve(followed_.size());
  for (const Followed& followed : followed_) {
    Motion ahead = followed.motion;
    ahead.predict(seconds(now - now_));
    all.push_back({followed.track.number, ahead.pose().x_m, ahead.pose().y_m, reach_m(followed, now)});
  }
  return all;
}

// As far as places tell: within an eighth of a body.
void Associator::find_touching() {
  const double near_m = settings_.diameter_m * 1.125, wall_m = settings_.diameter_m * 0.625;
  for (auto a = followed_.begin(); a != followed_.end(); ++a) {
    const hal::Pose at = a->motion.pose();
    a->touching =
        std::abs(at.x_m) > settings_.half_width_m - wall_m || std::abs(at.y_m) > settings_.half_height_m - wall_m;
    for (auto b = followed_.begin(); b != a; ++b) {
      const hal::Pose other = b->motion.pose();
      const double along_x = other.x_m - at.x_m, along_y = other.y_m - at.y_m;
      if (along_x * along_x + along_y * along_y < near_m * near_m) a->touching = b->touching = true;
    }
  }
}

bool Associator::touches(TrackNumber track) const {
  const auto at = std::ranges::find(followed_, track, [](const Followed& one) { return one.track.number; });
  return at != followed_.end() && at->touching;
}

double Associator::off_variance_m2(const Followed& followed, const FusedObservation& seen, hal::LabTime now) {
  const double sigma = followed.motion.place_sigma_m(), unseen_s = seconds(now - followed.last_seen);
  return sigma * sigma + seen.sigma_m * seen.sigma_m + push_m * push_m + start_m2_s3 * std::pow(unseen_s, 3);
}

// How much likelier it is that the track was seen there than that it was missed and a stranger came: logarithm of the
// ratio. The motion model's bell curve stands on a low plateau as wide as the reach, for robots that were pushed.
double Associator::gain(const Followed& followed, const FusedObservation& seen, hal::LabTime now) const {
  const hal::Pose at = followed.motion.pose();
  const double off_x = seen.x_m - at.x_m, off_y = seen.y_m - at.y_m, square = off_x * off_x + off_y * off_y;
  const double reach = reach_m(followed, now);
  if (square > reach * reach) return 0;
  const double variance = off_variance_m2(followed, seen, now);
  const double bell = std::exp(-square / (2 * variance)) / (2 * std::numbers::pi * variance);
  const double density = (1 - jump_probability) * bell + jump_probability / (std::numbers::pi * reach * reach);
  // One that has been out of sight for a while is likely to stay so.
  const double unseen_s = seconds(now_ - followed.last_seen);
  const double visible = std::max(0.1, seen_probability * std::exp(-unseen_s));
  return std::log(density * visible / ((1 - visible) * stranger_density)) + std::log(std::max(seen.confidence, 0.05f));
}

std::vector<Pairing> Associator::possible_pairs(hal::LabTime now, std::span<const FusedObservation> seen) const {
  std::vector<std::uint32_t> by_x(seen.size());
  for (std::uint32_t i = 0; i < seen.size(); ++i) by_x[i] = i;
  std::sort(by_x.begin(), by_x.end(),
            [&](auto a, auto b) { return seen[a].x_m != seen[b].x_m ? seen[a].x_m < seen[b].x_m : a < b; });
  std::vector<Pairing> possible;
  for (std::uint32_t row = 0; row < followed_.size(); ++row) {
    const double x_m = followed_[row].motion.pose().x_m, y_m = followed_[row].motion.pose().y_m,
                 reach = reach_m(followed_[row], now);
    auto it = std::lower_bound(by_x.begin(), by_x.end(), x_m - reach,
                               [&](auto i, double least) { return seen[i].x_m < least; });
    for (; it != by_x.end() && seen[*it].x_m <= x_m + reach; ++it) {
      if (std::abs(seen[*it].y_m - y_m) > reach) continue;
      if (const double gained = gain(followed_[row], seen[*it], now); gained > 0)
        possible.push_back({row, *it, gained});
    }
  }
  return possible;
}

// An assignment that is hardly better than the same with two tracks exchanged, or with one track elsewhere, is a guess.
void Associator::suspect_ambiguous(std::span<const Pairing> possible, std::span<const std::int32_t> column_of) {
  const auto gain_of = [&](std::uint32_t row, std::int32_t column) -> std::optional<double> {
    if (column == alone) return 0.0;
    const auto wanted = std::pair(row, static_cast<std::uint32_t>(column));
    // Ascending by row as they were made.
    auto it = std::lower_bound(possible.begin(), possible.end(), row,
                               [](const Pairing& p, std::uint32_t r) { return p.row < r; });
    for (; it != possible.end() && it->row == row; ++it)
      if (it->column == wanted.second) return it->gain;
    return {};
  };
  std::vector<std::int32_t> row_of;
  for (std::uint32_t row = 0; row < column_of.size(); ++row) {
    const std::int32_t column = column_of[row];
    if (column == alone) continue;
    if (row_of.size() <= static_cast<std::size_t>(column)) row_of.resize(column + 1, alone);
    row_of[column] = static_cast<std::int32_t>(row);
  }
  for (const Pairing& other : possible) {
    if (column_of[other.row] == static_cast<std::int32_t>(other.column)) continue;
    const double mine = gain_of(other.row, column_of[other.row]).value_or(0);
    const std::int32_t holder = other.column < row_of.size() ? row_of[other.column] : alone;
    if (holder == alone) {
      // Two observations that could be this robot.
      if (column_of[other.row] != alone && mine - other.gain < settings_.min_certainty) doubt(followed_[other.row]);
      continue;
    }
    const auto exchanged = gain_of(static_cast<std::uint32_t>(holder), column_of[other.row]);
    if (!exchanged) continue;
    const double theirs =
        gain_of(static_cast<std::uint32_t>(holder), static_cast<std::int32_t>(other.column)).value_or(0);
    if (mine + theirs - other.gain - *exchanged >= settings_.min_certainty) continue;
    doubt(followed_[other.row]);
    doubt(followed_[holder]);
  }
}

void Associator::doubt(Followed& followed) {
  if (followed.suspected) return;
  followed.suspected = true;
  counters_.add("track.doubtful");
}

void Associator::meet(Followed& followed, const FusedObservation& seen, hal::LabTime now) {
  if (now - followed.last_seen >= settings_.swap_after) doubt(followed);
  const bool settled = followed.times_seen >= settled_after;
  const hal::Pose at = followed.motion.pose();
  const double off_m = std::hypot(seen.x_m - at.x_m, seen.y_m - at.y_m);
  const double expected_m = 5 * std::sqrt(off_variance_m2(followed, seen, now));
  if (off_m > std::max(expected_m, settings_.diameter_m / 8)) {
    followed.motion.jump(seen.x_m, seen.y_m, seen.sigma_m);
    followed.jumped = true;
    counters_.add("track.jumped");
  } else {
    const auto misfit = followed.motion.see_place(seen.x_m, seen.y_m, seen.sigma_m);
    if (settled && misfit) places_.add(*misfit);
    followed.jumped = false;
  }
  Track& track = followed.track;
  track.led_seen = seen.led_confidence >= certain_led;
  if (track.led_seen) track.led = seen.led;
  if (seen.led != hal::Led::unknown)
    followed.led_told = now;
  else if (now - followed.led_told >= keep_led)
    track.led = hal::Led::unknown;
  track.led_direction_rad = seen.led_heading_rad;
  track.primary = seen.primary, track.primary_confidence = seen.primary_confidence;
  if (seen.led_heading_rad) {
    learn_led_noise(followed, seen, now);
    const auto misfit = followed.motion.see_heading(wrapped(*seen.led_heading_rad + led_offset(followed).rad),
                                                    led_noise_ * seen.led_heading_sigma_rad);
    if (settled && misfit) headings_.add(*misfit);
  }
  track.confidence += (1 - track.confidence) * 0.5f * seen.confidence;
  followed.last_seen = now;
  followed.shown = true;
  if (++followed.times_seen >= times_to_believe) followed.established = true;
}

// Of three looks in a row at a robot that turns evenly, the second difference is noise alone, with six times its
// variance. Half of such differences are below 0.6745 standard deviations, however far off turns, neighbours' lights
// and lamps throw single ones.
void Associator::learn_led_noise(Followed& followed, const FusedObservation& seen, hal::LabTime now) {
  const auto [newer, older] = followed.looks;
  followed.looks = {Followed::Look{now, *seen.led_heading_rad}, newer};
  const double step_s = seconds(now - newer.at), before_s = seconds(newer.at - older.at);
  if (step_s > 0.3 || std::abs(step_s - before_s) > 0.2 * step_s) return;
  if (std::abs(followed.motion.speed_m_s()) < walks_m_s) return;
  const double off_rad =
      std::abs(wrapped(wrapped(*seen.led_heading_rad - newer.led_rad) - wrapped(newer.led_rad - older.led_rad)));
  const bool more = off_rad > 0.6745 * std::sqrt(6) * led_noise_ * seen.led_heading_sigma_rad;
  led_noise_ = std::clamp(led_noise_ * (more ? 1 + noise_step : 1 / (1 + noise_step)), min_led_noise, max_led_noise);
}

void Associator::miss(Followed& followed, hal::LabTime now) {
  followed.track.led_seen = false;
  followed.track.led_direction_rad.reset();
  followed.track.primary_confidence = 0;
  followed.track.confidence *= static_cast<float>(std::exp(-2 * seconds(now - now_)));
  if (!followed.shown || now - followed.last_seen <= settings_.show_for) return;
  followed.shown = false;
  if (followed.established) counters_.add("track.ended");
}

void Associator::give_birth(std::span<const FusedObservation> seen, std::span<const std::int32_t> column_of,
                            hal::LabTime now) {
  std::vector<bool> taken(seen.size());
  for (const std::int32_t column : column_of)
    if (column != alone) taken[column] = true;
  const double min_m = 0.7 * settings_.diameter_m;
  std::vector<std::pair<double, double>> occupied;
  for (const Followed& followed : followed_)
    if (followed.last_seen == now) occupied.emplace_back(followed.motion.pose().x_m, followed.motion.pose().y_m);
  std::sort(occupied.begin(), occupied.end());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (taken[i]) continue;
    const auto close = [&](const auto& place) {
      return std::hypot(place.first - seen[i].x_m, place.second - seen[i].y_m) < min_m;
    };
    const auto begin = std::lower_bound(occupied.begin(), occupied.end(), std::pair(seen[i].x_m - min_m, -1e9));
    const auto end = std::upper_bound(begin, occupied.end(), std::pair(seen[i].x_m + min_m, 1e9));
    if (std::any_of(begin, end, close)) {
      counters_.add("seen.too_close");
      continue;
    }
    occupied.insert(std::upper_bound(begin, end, std::pair(seen[i].x_m, seen[i].y_m)), {seen[i].x_m, seen[i].y_m});
    Followed followed{.track = {},
                      .motion = Motion(seen[i].x_m, seen[i].y_m, seen[i].sigma_m, settings_.motion),
                      .last_seen = now,
                      .led_told = now};
    followed.track.number = next_++;
    followed.track.confidence = 0.5f * seen[i].confidence;
    followed.established = seen[i].confidence >= clear_confidence;
    followed.track.led_seen = seen[i].led_confidence >= certain_led;
    if (followed.track.led_seen || seen[i].led == hal::Led::unknown) followed.track.led = seen[i].led;
    followed.track.primary = seen[i].primary, followed.track.primary_confidence = seen[i].primary_confidence;
    if (seen[i].led_heading_rad)
      followed.motion.see_heading(wrapped(*seen[i].led_heading_rad + usual_led_offset_.rad),
                                  led_noise_ * seen[i].led_heading_sigma_rad);
    followed_.push_back(std::move(followed));
    counters_.add("track.born");
  }
}

void Associator::report(hal::LabTime now) {
  reported_.clear();
  for (Followed& followed : followed_) {
    Track& track = followed.track;
    track.in_arena = followed.motion.pose();
    const double noise_rad = followed.motion.heading_sigma_rad();
    track.heading_noise_rad = static_cast<float>(noise_rad);
    track.heading_sigma_rad =
        static_cast<float>(std::min(std::numbers::pi, std::hypot(noise_rad, led_offset(followed).error_rad)));
    track.age = now - followed.last_seen;
    track.doubtful = followed.suspected || followed.jumped || track.age >= settings_.doubt_after ||
                     track.confidence < settled_confidence;
    if (followed.established && followed.shown) reported_.push_back(track);
  }
}

const std::vector<Track>& Associator::update(hal::LabTime now, std::span<const FusedObservation> seen) {
  find_touching();
  for (Followed& followed : followed_) followed.motion.predict(seconds(now - now_), followed.touching);
  const std::vector<Pairing> possible = possible_pairs(now, seen);
  const auto rows = static_cast<std::uint32_t>(followed_.size()), columns = static_cast<std::uint32_t>(seen.size());
  const std::vector<std::int32_t> column_of = assign(rows, columns, possible);
  suspect_ambiguous(possible, column_of);
  for (std::size_t row = 0; row < column_of.size(); ++row) {
    if (column_of[row] != alone)
      meet(followed_[row], seen[column_of[row]], now);
    else
      miss(followed_[row], now);
  }
  give_birth(seen, column_of, now);
  std::erase_if(followed_, [&](const Followed& followed) {
    const hal::LabTime unseen = now - followed.last_seen;
    return unseen > settings_.forget_after || (!followed.established && unseen > settings_.doubt_after);
  });
  now_ = now;
  const auto count = [&](const char* name, double total) {
    counters_.set(name, static_cast<std::uint64_t>(std::llround(total)));
  };
  count("track.places", static_cast<double>(places_.n));
  count("track.places.off_um2", places_.sum.square * 1e12);
  count("track.places.misfit", places_.sum.normalised * 100);
  count("track.headings", static_cast<double>(headings_.n));
  count("track.headings.off_mrad2", headings_.sum.square * 1e6);
  count("track.headings.misfit", headings_.sum.normalised * 100);
  report(now);
  return reported_;
}

LedOffset Associator::led_offset(const Followed& followed) const {
  const auto own =
      followed.track.robot ? settings_.led_offsets.find(*followed.track.robot) : settings_.led_offsets.end();
  return own == settings_.led_offsets.end() ? usual_led_offset_ : own->second;
}

Associator::Followed* Associator::find(TrackNumber number) {
  const auto younger = [](const Followed& followed, TrackNumber wanted) { return followed.track.number < wanted; };
  const auto it = std::lower_bound(followed_.begin(), followed_.end(), number, younger);
  return it != followed_.end() && it->track.number == number ? &*it : nullptr;
}

bool Associator::name(TrackNumber track, hal::RobotId robot) {
  Followed* followed = find(track);
  if (!followed) return false;
  for (Followed& other : followed_)
    if (other.track.robot == robot && other.track.number != track) unname(other.track.number);
  if (followed->track.robot && *followed->track.robot != robot) counters_.add("track.renamed");
  followed->track.robot = robot;
  followed->suspected = false;
  report(now_);
  return true;
}

void Associator::unname(TrackNumber track) {
  Followed* followed = find(track);
  if (!followed) return;
  followed->track.robot.reset();
  followed->suspected = false;
  report(now_);
}

}  // namespace arkmesh::tracker
