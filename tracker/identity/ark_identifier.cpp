#include "tracker/identity/ark_identifier.hpp"

#include <algorithm>
#include <numeric>

namespace arkmesh::tracker {
namespace {

constexpr hal::LabTime blind{800'000};
constexpr int too_many_answers = 3;  // it is blue for reasons of its own

}  // namespace

ArkIdentifier::ArkIdentifier(ArkSettings settings) : settings_(std::move(settings)), to_call_(settings_.candidates) {
  if (!to_call_.empty()) return;
  to_call_.resize(settings_.largest + 1);
  std::iota(to_call_.begin(), to_call_.end(), 0u);
  settings_.candidates = to_call_;
}

void ArkIdentifier::on_frame(hal::LabTime now, std::span<const Track> tracks) {
  if (state_ == State::finished) return;
  if (state_ == State::ending) {
    if (now - ended_at_ >= settings_.ending) state_ = State::finished;
    return;
  }
  drop_unsure(tracks);
  tracks_ = tracks.size();
  if (!asked_at_) asked_at_ = now;
  if (now - *asked_at_ < settings_.times.settle) return;
  for (const Track& track : tracks) {
    if (track.doubtful || track.age > blind || (!track.led_seen && track.primary_confidence == 0)) continue;
    Count& count = counts_[track.number];
    ++(answer_of(track) == hal::Led::blue ? count.blue : count.other);
  }
  if (++pictures_ < settings_.times.pictures) return;
  conclude(now);
}

// What was found out about a track holds no longer when it is gone or may be another robot.
void ArkIdentifier::drop_unsure(std::span<const Track> tracks) {
  const auto unsure = [tracks](const auto& entry) {
    const auto at = std::find_if(tracks.begin(), tracks.end(),
                                 [&entry](const Track& track) { return track.number == entry.first; });
    return at == tracks.end() || at->doubtful || at->age > blind;
  };
  counters_.add("identity.doubted.unseen", std::erase_if(claims_, unsure));
  std::erase_if(answers_, unsure);
  std::erase_if(counts_, unsure);
}

// Who was blue enough for the id that was called.
void ArkIdentifier::conclude(hal::LabTime now) {
  const hal::RobotId robot = to_call_[position_];
  std::vector<Naming> blue;
  for (const auto& [track, count] : counts_) {
    const int all = count.blue + count.other;
    if (count.blue < 2 || 3 * count.blue < 2 * all) continue;
    ++answers_[track];
    if (answers_[track] > too_many_answers)
      counters_.add("identity.ignored.always_blue");
    else
      blue.push_back({track, robot, static_cast<float>(count.blue) / static_cast<float>(all)});
  }
  if (blue.size() > 1) {
    counters_.add("identity.refused.duplicate");
    duplicates_.push_back(robot);
  } else if (blue.size() == 1) {
    // a track that answers to two ids is believed neither
    if (answers_[blue[0].track] == 1)
      claims_[blue[0].track] = {robot, blue[0].confidence};
    else
      counters_.add("identity.refused.two_ids");
  }
  for (const Naming& naming : blue)
    if (answers_[naming.track] > 1) claims_.erase(naming.track);
  next_id(now);
}

void ArkIdentifier::next_id(hal::LabTime now) {
  asked_at_ = now;
  pictures_ = 0;
  counts_.clear();
  ++position_;
  const bool everybody = claims_.size() >= std::min(tracks_, settings_.candidates.size());
  if (!everybody && position_ < to_call_.size()) return;
  if (!everybody && round_ < settings_.max_rounds) {
    // once more, those who did not answer
    ++round_;
    to_call_.clear();
    for (hal::RobotId robot : settings_.candidates)
      if (std::none_of(claims_.begin(), claims_.end(),
                       [robot](const auto& claim) { return claim.second.robot == robot; }))
        to_call_.push_back(robot);
    position_ = 0;
    duplicates_.clear();
    std::erase_if(answers_, [](const auto& entry) { return entry.second < too_many_answers; });
    return;
  }
  for (const auto& [track, claim] : claims_) namings_.push_back({track, claim.robot, claim.confidence});
  counters_.add("identity.named", namings_.size());
  state_ = State::ending;
  ended_at_ = now;
}

std::optional<Question> ArkIdentifier::question() const {
  if (state_ == State::finished) return std::nullopt;
  return ark_question(settings_.runtime ? ark_runtime_type : ark_initial_type,
                      state_ == State::ending ? nobody : to_call_[position_]);
}

std::optional<hal::RobotId> ArkIdentifier::called() const {
  if (state_ != State::asking) return std::nullopt;
  return to_call_[position_];
}

}  // namespace arkmesh::tracker
