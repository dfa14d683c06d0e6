#include "tracker/identity/identity_keeper.hpp"

#include <algorithm>
#include <set>

namespace arkmesh::tracker {
namespace {

constexpr hal::LabTime first_pause{2'000'000};   // after a round of questions that nobody new answered
constexpr hal::LabTime longest_calm{3'000'000};  // somebody is waited for at most
constexpr hal::LabTime glimpse{300'000};         // a track not seen for less counts as seen
constexpr int first_rounds = 3;                  // barren ones before the rest is taken for silent
constexpr std::size_t max_by_list = 12;          // more are found sooner by asking everybody

bool holds(std::span<const hal::RobotId> robots, hal::RobotId robot) {
  return std::binary_search(robots.begin(), robots.end(), robot);
}

void insert(std::vector<hal::RobotId>& robots, hal::RobotId robot) {
  const auto at = std::lower_bound(robots.begin(), robots.end(), robot);
  if (at == robots.end() || *at != robot) robots.insert(at, robot);
}

}  // namespace

IdentityKeeper::IdentityKeeper(IdentitySettings settings)
    : settings_(std::move(settings)),
      reader_(settings_.times, counters_),
      known_(settings_.expected),
      unaccounted_(settings_.expected) {}

void IdentityKeeper::on_frame(hal::LabTime now, std::span<const Track> tracks) {
  now_ = now;
  update_book(now, tracks);
  update_unaccounted();

  if (asked_) {
    if (reader_.audience().kind == Audience::Kind::everybody) {
      reader_.on_frame(now, tracks);
    } else {
      // of the others LEDs say what their programs do
      std::vector<Track> in_question;
      for (const Track& track : tracks)
        if (!book_.at(track.number).sure()) in_question.push_back(track);
      reader_.on_frame(now, in_question);
    }
    if (reader_.asking()) return;
    asked_ = false;
    use_readings(now);
    update_unaccounted();
  }
  if (worth_asking(now)) ask();
}

void IdentityKeeper::update_book(hal::LabTime now, std::span<const Track> tracks) {
  std::map<TrackNumber, Entry> book;
  for (const Track& track : tracks) {
    const auto before = book_.find(track.number);
    Entry entry = before == book_.end() ? Entry{} : before->second;
    if (track.age > settings_.blind) {
      if (entry.sure()) counters_.add("identity.doubted.hidden");
      entry.unname();
      reader_.forget(track.number);
    } else if (track.doubtful) {
      if (entry.sure()) {
        counters_.add("identity.doubted.swapped");
        entry.doubted = true;
        entry.seen_since.reset();  // the doubt may pass by itself
        reader_.forget(track.number);
      }
    } else if (entry.doubted) {
      if (track.robot == entry.robot)
        entry.doubted = false;
      else
        entry.unname();
    }
    entry.seen = track.age <= glimpse;
    if (!entry.seen)
      entry.seen_since.reset();
    else if (!entry.seen_since)
      entry.seen_since = now;
    book.emplace(track.number, entry);
  }
  for (const auto& [number, entry] : book_) {
    if (book.contains(number)) continue;
    reader_.forget(number);
    if (entry.sure()) counters_.add("identity.doubted.unseen");
  }
  book_ = std::move(book);
}

void IdentityKeeper::update_unaccounted() {
  std::set<hal::RobotId> named;
  for (const auto& [number, entry] : book_)
    if (entry.sure()) named.insert(*entry.robot);
  unaccounted_.clear();
  for (hal::RobotId robot : known_)
    if (!named.contains(robot)) unaccounted_.push_back(robot);
}

bool IdentityKeeper::worth_asking(hal::LabTime now) const {
  if (now < not_before_) return false;
  // later only those are asked who are missed
  if ((began_ || !settings_.expected.empty()) && unaccounted_.empty()) return false;
  bool calm = false, restless = false;
  for (const auto& [number, entry] : book_) {
    if (entry.sure() || !entry.seen) continue;
    const hal::LabTime seen = now - *entry.seen_since;
    if (seen < settings_.calm)
      restless = true;
    else
      calm = true;
    if (seen >= longest_calm) return true;
  }
  return calm && !restless;
}

int IdentityKeeper::digits_needed(const Audience& audience) const {
  // somebody may have a longer id than anybody thought
  if (!began_ && barren_passes_ > 0 && audience.kind == Audience::Kind::everybody) return max_id_digits;
  const hal::RobotId largest = settings_.expected.empty() ? settings_.largest : settings_.expected.back();
  return id_digits(std::max(largest, known_.empty() ? 0 : known_.back()));
}

void IdentityKeeper::ask() {
  Audience audience;
  // A few are asked by themselves: among dark neighbours a LED is seen best. Who is there unexpected shows only when
  // everybody is asked, once.
  const std::size_t missed = unaccounted_.size();
  const bool by_name = missed > 0 && missed <= max_by_list &&
                       (began_ || (passes_ > 0 && (barren_passes_ == 0 ? missed <= 4 : barren_passes_ > 1)));
  if (by_name) {
    std::vector<hal::RobotId> named;
    for (hal::RobotId robot : known_)
      if (!holds(unaccounted_, robot)) named.push_back(robot);
    audience = audience_for(unaccounted_, named, turn_);
    turn_ += audience.robots.size();
  }
  // colours of nameless robots that were not asked are no digits
  const bool part = by_name && !std::all_of(unaccounted_.begin(), unaccounted_.end(),
                                            [&](hal::RobotId robot) { return audience.includes(robot); });
  if (part || asked_part_) reader_.forget_all();
  asked_part_ = part;
  std::vector<TrackNumber> nameless;
  for (const auto& [number, entry] : book_)
    if (!entry.sure() && entry.seen) nameless.push_back(number);
  reader_.ask(audience, digits_needed(audience), nameless);
  asked_ = true;
  tell_end_until_.reset();
  ++passes_;
}

void IdentityKeeper::use_readings(hal::LabTime now) {
  const Audience& asked = reader_.audience();
  const std::vector<DigitReader::Reading> readings =
      reader_.take_readings(asked.kind == Audience::Kind::list ? std::span<const hal::RobotId>(asked.robots)
                                                               : std::span<const hal::RobotId>());
  std::map<hal::RobotId, int> spelled_by;
  duplicates_.clear();
  for (const auto& reading : readings) ++spelled_by[reading.robot];

  int named = 0;
  for (const auto& reading : readings) {
    const auto at = book_.find(reading.track);
    if (at == book_.end()) continue;
    Entry& entry = at->second;
    if (entry.sure() && entry.robot == reading.robot && spelled_by[reading.robot] == 1) continue;
    // whatever it was called, it says something else, or another one says the same
    if (entry.sure()) {
      counters_.add("identity.doubted.contradiction");
      entry.unname();
      continue;
    }
    if (spelled_by[reading.robot] > 1) {
      counters_.add("identity.refused.duplicate");
      insert(duplicates_, reading.robot);
      continue;
    }
    if (!settings_.expected.empty() && !holds(settings_.expected, reading.robot)) {
      counters_.add("identity.refused.stranger");
      insert(strangers_, reading.robot);
      continue;
    }
    if (!reader_.audience().includes(reading.robot)) {
      counters_.add("identity.refused.not_asked");
      continue;
    }
    const auto holder = std::find_if(book_.begin(), book_.end(), [&](const auto& other) {
      return other.second.sure() && other.second.robot == reading.robot;
    });
    if (holder != book_.end()) {
      counters_.add("identity.doubted.contradiction");
      holder->second.unname();
      continue;
    }
    entry.robot = reading.robot;
    entry.doubted = false;
    insert(known_, reading.robot);
    namings_.push_back({reading.track, reading.robot, reading.confidence});
    ++named;
  }
  counters_.add("identity.named", static_cast<std::uint64_t>(named));

  // a part of a spelling that somebody with a name gave would pass for another's later
  for (const auto& [number, entry] : book_)
    if (entry.sure()) reader_.forget(number);

  barren_passes_ = named > 0 ? 0 : barren_passes_ + 1;
  update_unaccounted();
  const bool all = std::all_of(book_.begin(), book_.end(),
                               [](const auto& entry) { return entry.second.sure() || !entry.second.seen; });
  if ((settings_.expected.empty() ? all : unaccounted_.empty()) || barren_passes_ >= first_rounds) began_ = true;
  if (barren_passes_ > 0 && began_) {
    hal::LabTime pause = first_pause;
    for (int i = 1; i < barren_passes_ && pause < settings_.longest_pause; ++i) pause *= 2;
    not_before_ = now + std::min(pause, settings_.longest_pause);
  }
  tell_end_until_ = now + settings_.ending;
}

std::optional<Question> IdentityKeeper::question() const {
  if (asked_) return reader_.question();
  if (tell_end_until_ && now_ < *tell_end_until_) return end_of_questions();
  return std::nullopt;
}

std::optional<hal::RobotId> IdentityKeeper::robot_of(TrackNumber track) const {
  const auto at = book_.find(track);
  return at == book_.end() || at->second.doubted ? std::nullopt : at->second.robot;
}

bool IdentityKeeper::everybody_named() const {
  if (!settings_.expected.empty()) return unaccounted_.empty();
  return began_ && !book_.empty() &&
         std::all_of(book_.begin(), book_.end(), [](const auto& entry) { return entry.second.sure(); });
}

bool IdentityKeeper::led_is_answer(TrackNumber track) const {
  if (!asked_ && !(tell_end_until_ && now_ < *tell_end_until_ + settings_.times.settle)) return false;
  if (reader_.audience().kind == Audience::Kind::everybody) return true;
  const auto robot = robot_of(track);
  return !robot || reader_.audience().includes(*robot);
}

bool IdentityKeeper::settled(int passes) const {
  if (asked_ || (tell_end_until_ && now_ < *tell_end_until_)) return false;
  return everybody_named() || barren_passes_ >= passes;
}

IdentityKeeper::Progress IdentityKeeper::progress() const {
  Progress out{.passes = passes_, .tracks = static_cast<int>(book_.size())};
  if (asked_) {
    out.digit = reader_.position() + 1;
    out.digits = reader_.digits();
  }
  for (const auto& [number, entry] : book_) out.named += entry.sure();
  return out;
}

}  // namespace arkmesh::tracker
