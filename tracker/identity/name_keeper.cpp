#include "tracker/identity/name_keeper.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "tracker/identity/ark_identifier.hpp"

namespace arkmesh::tracker {
namespace {

class SpelledNames final : public NameKeeper {
 public:
  explicit SpelledNames(std::vector<hal::RobotId> expected) : keeper_({.expected = std::move(expected)}) {}
  void on_frame(hal::LabTime now, std::span<const Track> tracks) override { keeper_.on_frame(now, tracks); }
  std::optional<Question> question() const override { return keeper_.question(); }
  std::vector<Naming> take_namings() override { return keeper_.take_namings(); }
  std::optional<hal::RobotId> robot_of(TrackNumber track) const override { return keeper_.robot_of(track); }
  std::span<const hal::RobotId> doubtful() const override { return keeper_.doubtful(); }
  bool everybody_named() const override { return keeper_.everybody_named(); }
  bool led_is_answer(TrackNumber track) const override { return keeper_.led_is_answer(track); }
  const hal::Counters& counters() const override { return keeper_.counters(); }

 private:
  IdentityKeeper keeper_;
};

// Runs ARK's procedure whenever robots are unaccounted for and tracks without a sure name have been in calm sight for a
// while.
class ArkNames final : public NameKeeper {
 public:
  explicit ArkNames(std::vector<hal::RobotId> expected) : expected_(std::move(expected)), unaccounted_(expected_) {}

  void on_frame(hal::LabTime now, std::span<const Track> tracks) override {
    update_book(tracks);
    const auto nameless = [&](const Track& track) { return !robot_of(track.number) && track.age.count() == 0; };
    const bool anybody = std::any_of(tracks.begin(), tracks.end(), nameless);
    calm_since_ = anybody && !unaccounted_.empty() ? calm_since_.value_or(now) : std::optional<hal::LabTime>();
    if (!asking_ && calm_since_ && now - *calm_since_ >= calm && now >= not_before_) begin();
    if (!asking_) return;
    asking_->on_frame(now, in_question(tracks));
    for (const Naming& naming : asking_->take_namings()) take(naming);
    update_unaccounted();
    if (!asking_->finished()) return;
    counters_.merge(asking_->counters());
    asking_.reset();
    named_once_ = true;
    not_before_ = now + pause;
    calm_since_.reset();
  }

  std::optional<Question> question() const override { return asking_ ? asking_->question() : std::nullopt; }
  std::vector<Naming> take_namings() override { return std::exchange(namings_, {}); }
  std::optional<hal::RobotId> robot_of(TrackNumber track) const override {
    const auto entry = book_.find(track);
    return entry != book_.end() && !entry->second.doubted ? entry->second.robot : std::nullopt;
  }
  std::span<const hal::RobotId> doubtful() const override { return unaccounted_; }
  bool everybody_named() const override { return unaccounted_.empty(); }
  // Everybody shows red or blue while somebody is called.
  bool led_is_answer(TrackNumber) const override { return asking_.has_value(); }
  const hal::Counters& counters() const override { return counters_; }

 private:
  static constexpr hal::LabTime calm{1'000'000}, pause{3'000'000};
  struct Entry {
    std::optional<hal::RobotId> robot;
    bool doubted = false;
  };

  void update_book(std::span<const Track> tracks) {
    std::map<TrackNumber, Entry> book;
    for (const Track& track : tracks) {
      const auto before = book_.find(track.number);
      Entry entry = before == book_.end() ? Entry{} : before->second;
      if (track.doubtful && entry.robot && !entry.doubted) counters_.add("identity.doubted");
      entry.doubted = track.doubtful;
      book.emplace(track.number, entry);
    }
    book_ = std::move(book);
    update_unaccounted();
  }

  void update_unaccounted() {
    std::vector<hal::RobotId> sure;
    for (const auto& [track, entry] : book_)
      if (entry.robot && !entry.doubted) sure.push_back(*entry.robot);
    std::sort(sure.begin(), sure.end());
    unaccounted_.clear();
    std::set_difference(expected_.begin(), expected_.end(), sure.begin(), sure.end(), std::back_inserter(unaccounted_));
  }

  void begin() {
    ArkSettings settings;
    settings.candidates = unaccounted_;
    settings.runtime = named_once_;
    asking_.emplace(settings);
    counters_.add("identity.asked");
  }

  // Tracks without a sure name. That they are doubtful is why they are asked: to the identifier they are new.
  std::vector<Track> in_question(std::span<const Track> tracks) const {
    std::vector<Track> wanted;
    for (Track track : tracks) {
      if (robot_of(track.number)) continue;
      track.doubtful = track.age.count() > 300'000;
      wanted.push_back(track);
    }
    return wanted;
  }

  void take(const Naming& naming) {
    if (!std::binary_search(expected_.begin(), expected_.end(), naming.robot))
      return counters_.add("identity.stranger");
    for (auto& [track, entry] : book_)
      if (entry.robot == naming.robot) entry = {};
    book_[naming.track] = {naming.robot, false};
    namings_.push_back(naming);
    counters_.add("identity.named");
  }

  std::vector<hal::RobotId> expected_, unaccounted_;
  std::map<TrackNumber, Entry> book_;
  std::optional<ArkIdentifier> asking_;
  std::optional<hal::LabTime> calm_since_;
  hal::LabTime not_before_{0};
  bool named_once_ = false;
  std::vector<Naming> namings_;
  hal::Counters counters_;
};

}  // namespace

std::unique_ptr<NameKeeper> make_spelled_names(std::vector<hal::RobotId> expected) {
  return std::make_unique<SpelledNames>(std::move(expected));
}
std::unique_ptr<NameKeeper> make_ark_names(std::vector<hal::RobotId> expected) {
  return std::make_unique<ArkNames>(std::move(expected));
}

}  // namespace arkmesh::tracker
