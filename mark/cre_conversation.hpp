// CRE with an original: both sides say their state again and again; there is no beginning and no answer.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mark/conversation.hpp"

namespace arkmesh::mark {

// The original is the client, the ground swarm: it is told the flying robots.
class CreServerConversation final : public Conversation {
 public:
  void came() override { is_new_ = true; }
  void gone() override;
  void hear(const Message& message) override;
  std::optional<std::string> say() const override;
  void said() override {}
  bool may_begin() const override { return !active_.empty(); }
  std::string awaited() const override { return "the resources"; }
  void end() override { gone(); }

  void set_robots(std::vector<FlyingRobot> robots) { robots_ = std::move(robots); }
  // Per place, as it said last: 1 where a resource is; empty before.
  const std::vector<int>& active() const { return active_; }
  // How often it began with some.
  int begun() const { return begun_; }
  // How often a place of the north, of the south lost its resource.
  const std::array<std::int64_t, 2>& harvested() const { return harvested_; }

 private:
  bool is_new_ = false;  // its next resources are those that it begins with: none was harvested
  int begun_ = 0;
  std::vector<FlyingRobot> robots_;
  std::vector<int> active_;
  std::array<std::int64_t, 2> harvested_{};
};

// The original is the server, the flying swarm: it is told the resources.
class CreClientConversation final : public Conversation {
 public:
  // `robots`: mark.robots, of `file`.
  CreClientConversation(std::size_t robots, int side_cm, std::string file)
      : count_(robots), side_cm_(side_cm), file_(std::move(file)) {}
  void came() override {}
  void gone() override { robots_.clear(); }
  void hear(const Message& message) override;
  std::optional<std::string> say() const override;
  void said() override {}
  bool may_begin() const override { return !robots_.empty(); }
  std::string awaited() const override { return "the robots"; }
  void end() override {}

  // Per place: 1 where a resource is.
  void set_active(std::vector<int> active) { active_ = std::move(active); }
  // As it said last.
  const std::vector<FlyingRobot>& robots() const { return robots_; }

 private:
  std::size_t count_;
  int side_cm_;
  std::string file_;
  std::vector<int> active_;
  std::vector<FlyingRobot> robots_;
};

}  // namespace arkmesh::mark
