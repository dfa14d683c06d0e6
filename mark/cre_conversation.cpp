#include "mark/cre_conversation.hpp"

#include <fmt/format.h>

#include "hal/counted.hpp"

namespace arkmesh::mark {

void CreServerConversation::hear(const Message& message) {
  const auto active = read_resources(message.text);
  if (message.word != Word::resources || !active) return;
  // Places 0 to 49 are the north's.
  for (std::size_t i = 0; i < active_.size(); ++i)
    if (active_[i] == 1 && (*active)[i] == 0) ++harvested_[i < places / 2 ? 0 : 1];
  active_ = *active;
}

std::optional<std::string> CreServerConversation::say() const {
  if (robots_.empty()) return {};
  if (!ended_) return to_text(robots_);
  // Nobody is led by robots that are no longer there.
  std::vector<FlyingRobot> silent = robots_;
  for (FlyingRobot& robot : silent) robot.commitment = 0;
  return to_text(silent);
}

void CreClientConversation::hear(const Message& message) {
  const auto robots = read_robots(message.text, side_cm_);
  if (message.word != Word::robots || !robots) return;
  if (robots->size() != count_)
    return conflict(fmt::format("{}: mark.robots = {}, and the original server tells of {}: set mark.robots = {}",
                                file_, count_, hal::counted(robots->size(), "robot"), robots->size()));
  robots_ = *robots;
}

std::optional<std::string> CreClientConversation::say() const {
  if (active_.empty()) return {};
  return resources_text(active_);
}

}  // namespace arkmesh::mark
