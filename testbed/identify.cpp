#include "testbed/identify.hpp"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "tracker/identity/ark_identifier.hpp"
#include "tracker/identity/identity_keeper.hpp"

namespace arkmesh::testbed {
namespace {

using Protocol = IdentifySettings::Protocol;

// One run of the procedure: who has been found so far, and what is to be seen now.
class Identification {
 public:
  Identification(SetUpArena& arena, const IdentifySettings& settings, hal::StopRequest& stop, hal::Progress& progress)
      : arena_(arena), settings_(settings), stop_(stop), progress_(progress) {
    const auto ids =
        static_cast<double>(settings.expected.empty() ? arena.info().max_robot + 1 : settings.expected.size());
    max_s_ = settings.max_s > 0 ? settings.max_s : settings.protocol == Protocol::spelled ? 120 : 60 + 3 * ids;
  }

  void ask_spelled() {
    tracker::IdentityKeeper keeper({.expected = settings_.expected, .largest = arena_.info().max_robot});
    std::map<tracker::TrackNumber, float> confidence;
    while (!keeper.settled(3) && goes_on()) {
      keeper.on_frame(arena_.now(), look(keeper.question()));
      for (const tracker::Naming& naming : keeper.take_namings()) {
        arena_.name(naming.track, naming.robot);
        confidence[naming.track] = naming.confidence;
        report_.took_s = arena_.seconds();
      }
      const auto now = keeper.progress();
      progress_.show(fmt::format("{:.1f} s, {} of {} robots named, {}", arena_.seconds(), now.named, now.tracks,
                                 now.digits ? fmt::format("round {}, digit {} of {}", now.passes, now.digit, now.digits)
                                            : "no robot is asked"));
    }
    for (const auto& [number, track] : tracks_)
      if (const auto robot = keeper.robot_of(number)) found_[*robot] = {number, *robot, confidence[number]};
    report_.duplicates.assign(keeper.duplicates().begin(), keeper.duplicates().end());
    report_.strangers.assign(keeper.strangers().begin(), keeper.strangers().end());
  }

  void ask_as_ark() {
    tracker::ArkIdentifier identifier({.candidates = settings_.expected,
                                       .largest = arena_.info().max_robot,
                                       .runtime = settings_.protocol == Protocol::ark_runtime});
    // the first picture with somebody in it
    while (tracks_.empty() && goes_on()) look({});
    while (!identifier.finished() && goes_on()) {
      identifier.on_frame(arena_.now(), look(identifier.question()));
      for (const tracker::Naming& naming : identifier.take_namings()) {
        found_[naming.robot] = naming;
        report_.took_s = arena_.seconds();
      }
      if (const auto called = identifier.called())
        progress_.show(fmt::format("{:.1f} s, {} of {} robots named, calling {}", arena_.seconds(), identifier.named(),
                                   tracks_.size(), *called));
    }
    report_.duplicates = identifier.duplicates();
  }

  IdentifyReport report() {
    for (const auto& [robot, naming] : found_) {
      const auto track = tracks_.find(naming.track);
      report_.named.push_back(
          {robot, track == tracks_.end() ? hal::Pose{} : track->second.in_arena, naming.confidence});
      if (track != tracks_.end()) tracks_.erase(track);
    }
    for (const auto& [number, track] : tracks_) report_.nameless.push_back(track.in_arena);
    for (const hal::RobotId robot : settings_.expected)
      if (!found_.contains(robot)) report_.missing.push_back(robot);
    const bool anybody = settings_.expected.empty();
    report_.looked_for = anybody ? found_.size() + tracks_.size() : settings_.expected.size();
    report_.simulated = arena_.is_simulated();
    report_.complete = report_.missing.empty() && !found_.empty() && (!anybody || tracks_.empty());
    return std::move(report_);
  }

 private:
  bool goes_on() { return arena_.seconds() < max_s_ && !stop_.stopped(); }

  std::span<const tracker::Track> look(const std::optional<tracker::Question>& question) {
    const auto seen = arena_.next_picture(question);
    tracks_.clear();
    for (const tracker::Track& track : seen) tracks_.emplace(track.number, track);
    return seen;
  }

  SetUpArena& arena_;
  const IdentifySettings& settings_;
  hal::StopRequest& stop_;
  hal::Progress& progress_;
  double max_s_;
  std::map<tracker::TrackNumber, tracker::Track> tracks_;
  std::map<hal::RobotId, tracker::Naming> found_;
  IdentifyReport report_;
};

}  // namespace

IdentifyReport identify(SetUpArena& arena, const IdentifySettings& settings, hal::StopRequest& stop,
                        hal::Progress& progress) {
  Identification identification(arena, settings, stop, progress);
  if (settings.protocol == Protocol::spelled)
    identification.ask_spelled();
  else
    identification.ask_as_ark();
  progress.done();
  return identification.report();
}

}  // namespace arkmesh::testbed
