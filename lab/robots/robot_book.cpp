#include "lab/robots/robot_book.hpp"

#include <algorithm>
#include <utility>

#include "hal/arenas/messages.hpp"

namespace arkmesh::lab {
namespace {

constexpr std::size_t most_pauses = 1000;  // in the result; a scenario may pause its robots all the time
constexpr std::size_t most_parameters = 64;
constexpr hal::LabTime again_after{5'000'000};

// Robots rest, and a word that makes them stand would wake them.
bool rests(RobotBook::Kind kind) {
  using Kind = RobotBook::Kind;
  return kind == Kind::sleep || kind == Kind::charge || kind == Kind::voltage;
}

}  // namespace

void RobotBook::begin(hal::LabTime now) {
  begun_ = true;
  update(now);
}

void RobotBook::end(hal::LabTime now) {
  ended_ = true;
  update(now);
}

void RobotBook::say(Who who, const hal::FleetCommand& command, hal::LabTime now, std::string_view name) {
  if (command.kind == Kind::broadcast || std::ranges::count(arena_.info().commands, command.kind) == 0)
    return tell(command, now);
  Wish& wish = wishes_[static_cast<std::size_t>(who)];
  if (command.kind == Kind::reset) {
    tell(command, now);
    told_ = Kind::pause;
    parameters_due_ = reset_ = true;
    words_.doubt(hal::everyone, RobotWords::for_sure);
  }
  wish.kind = command.kind == Kind::reset ? Kind::pause : command.kind;
  if (!name.empty()) wish.name = name;
  const bool again = told_ == command.kind && (who == Who::operators || who == Who::scenario);
  update(now);
  if (again && told_ == command.kind) tell(command, now);  // for robots that did not hear it
}

void RobotBook::prepare(std::span<const hal::WholeMessage> parameters) {
  std::vector<hal::WholeMessage> all = parameters_;
  std::erase_if(all, [&](const hal::WholeMessage& known) {
    return std::ranges::find(parameters, known.type, &hal::WholeMessage::type) != parameters.end();
  });
  all.insert(all.end(), parameters.begin(), parameters.end());
  std::ranges::stable_sort(all, {}, &hal::WholeMessage::type);
  if (all == parameters_) return;
  if (all.size() > most_parameters) return counters_.add("parameters.refused.too_many", parameters.size());
  parameters_ = std::move(all);
  parameters_due_ = true;
}

void RobotBook::see(const hal::PoseFrame& frame) {
  for (const hal::Observation& robot : frame.robots) {
    const hal::LabTime seen = frame.stamp - robot.age;
    const auto [last, is_new] = seen_.try_emplace(robot.robot, seen);
    if (is_new ? begun_ : seen - last->second >= absent_) {
      counters_.add("robots.seen_again");
      doubt(robot.robot);
    }
    last->second = std::max(last->second, seen);
  }
}

void RobotBook::catch_up(hal::LabTime now) {
  const hal::NotHeard lost = arena_.robots().not_heard();
  for (const hal::RobotId robot : lost.words) words_.doubt(robot, 1);
  counters_.add("robots.restarted", lost.restarted.size());
  for (const hal::RobotId robot : lost.restarted) doubt(robot);
  if (std::exchange(openings_, lost.openings) != lost.openings) doubt(hal::everyone);
  for (const std::uint8_t type : lost.broadcasts)
    if (std::ranges::find(parameters_, type, &hal::WholeMessage::type) != parameters_.end())
      parameters_due_ = lack_ = true;
  if (told_ != Kind::run || !lack_ || now - lack_told_ < again_after) return;
  lack_told_ = now;
  parameters_due_ = lack_ = false;
  tell_parameters(1, now);
  tell({.kind = Kind::run}, now);
  counters_.add("parameters.told_again", parameters_.size());
  counters_.add("run.told_again");
}

void RobotBook::doubt(hal::RobotId robot) {
  words_.doubt(robot, RobotWords::for_sure);
  parameters_due_ = lack_ = true;
}

hal::Counters RobotBook::counters() const {
  hal::Counters all = counters_;
  all.add("to_robots.told_again", words_.told_again());
  return all;
}

RobotBook::Kind RobotBook::wanted() const {
  const auto resting = std::ranges::find_if(wishes_, rests, &Wish::kind);
  if (resting != wishes_.end()) return resting->kind;
  const bool runs = begun_ && !ended_ && std::ranges::count(wishes_, Kind::run, &Wish::kind) == std::ssize(wishes_);
  return runs ? Kind::run : Kind::pause;
}

std::string RobotBook::kept_still_by() const {
  if (ended_) return "end";
  const auto otherwise = std::ranges::find_if(wishes_, [](const Wish& wish) { return wish.kind != Kind::run; });
  if (otherwise != wishes_.end()) return otherwise->name;
  return begun_ ? "" : "not begun";
}

void RobotBook::tell(const hal::FleetCommand& command, hal::LabTime now) {
  bus_.publish(hal::channel::fleet_command, hal::to_message(command, now));
  arena_.robots().command(command);
}

// In turns, so that what spoils the air for a moment spoils no parameter.
void RobotBook::tell_parameters(int rounds, hal::LabTime now) {
  for (int round = 0; round < rounds; ++round)
    for (const auto& [type, data] : parameters_) tell({.kind = Kind::broadcast, .type = type, .data = data}, now);
}

// The arena repeats what robots may not have heard.
void RobotBook::update(hal::LabTime now) {
  keep_records(now);
  if (std::exchange(told_, wanted()) == told_) return;
  if (told_ == Kind::run) {
    if (std::exchange(parameters_due_, false)) tell_parameters(start_rounds, now);
    // what was said before `setup` may be lost in it
    if (std::exchange(reset_, false)) words_.doubt(hal::everyone, RobotWords::for_sure);
    lack_ = false;
  }
  tell({.kind = told_}, now);
}

// The end leaves open what stands.
void RobotBook::keep_records(hal::LabTime now) {
  if (ended_) return;
  for (std::size_t who = 0; who < wishes_.size(); ++who) {
    const bool keeps = begun_ && wishes_[who].kind != Kind::run;
    if (open_[who] && (!keeps || pauses_[*open_[who]].who != wishes_[who].name)) {
      pauses_[*open_[who]].until = now;
      open_[who].reset();
    }
    if (!keeps || open_[who]) continue;
    if (pauses_.size() == most_pauses) {
      counters_.add("pauses.not_listed");
      continue;
    }
    open_[who] = pauses_.size();
    pauses_.push_back({wishes_[who].name, now, {}});
  }
}

}  // namespace arkmesh::lab
