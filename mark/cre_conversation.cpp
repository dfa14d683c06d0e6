#include "mark/cre_conversation.hpp"

#include <fmt/format.h>

#include <utility>

#include "hal/counted.hpp"

namespace arkmesh::mark {

void CreServerConversation::hear(const Message& message) {
  const auto active = read_resources(message.text);
  if (message.word != Word::resources || !active) return;
  // Places 0 to 49 are the north's.
  for (std::size_t i = 0; i < active_.size() && !is_new_; ++i)
    if (active_[i] == 1 && (*active)[i] == 0) ++harvested_[i < places / 2 ? 0 : 1];
  active_ = *active;
  begun_ += std::exchange(is_new_, false);
}

// Nobody is led by robots of which nothing is known.
void CreServerConversation::gone() {
  for (FlyingRobot& robot : robots_) robot.commitment = 0;
}

std::optional<std::string> CreServerConversation::say() const {
  if (robots_.empty()) return {};
  return to_text(robots_);
}

void CreClientConversation::hear(const Message& message) {
  const auto robots = read_robots(message.text, side_cm_);
  if (message.word != Word::robots || !robots) return;
  if (robots->size() != count_)
    return conflict(fmt::format("{}: mark.robots = {}, but the original server reports {}; set mark.robots = {}", file_,
                                count_, hal::counted(robots->size(), "robot"), robots->size()));
  robots_ = *robots;
}

std::optional<std::string> CreClientConversation::say() const {
  if (active_.empty()) return {};
  return resources_text(active_);
}

}  // namespace arkmesh::mark
