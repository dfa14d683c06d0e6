// What a watch needs to know about who is who, however it is found out: the identifiers behind one interface.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hal/counters.hpp"
#include "tracker/follow/track.hpp"
#include "tracker/identity/identity_keeper.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::tracker {

class NameKeeper {
 public:
  virtual ~NameKeeper() = default;
  virtual void on_frame(hal::LabTime now, std::span<const Track> tracks) = 0;
  virtual std::optional<Question> question() const = 0;
  virtual std::vector<Naming> take_namings() = 0;
  virtual std::optional<hal::RobotId> robot_of(TrackNumber track) const = 0;
  virtual std::span<const hal::RobotId> doubtful() const = 0;
  virtual bool everybody_named() const = 0;
  virtual bool led_is_answer(TrackNumber track) const = 0;
  virtual const hal::Counters& counters() const = 0;
};

// Robots that spell their ids when asked (a controller with arkmesh_id.h). `expected` ascending.
std::unique_ptr<NameKeeper> make_spelled_names(std::vector<hal::RobotId> expected);
// Robots that know ARK's messages only: 120 before the first names are known, 119 for those who got lost later.
std::unique_ptr<NameKeeper> make_ark_names(std::vector<hal::RobotId> expected);

}  // namespace arkmesh::tracker
