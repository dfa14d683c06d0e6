// Eyes on a testbed of real Kilobots. To find out which robot is which it has to ask them, over the overhead controller
// that the arena owns: so it tells the arena what to ask.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/platforms/kilobot/message.hpp"

namespace arkmesh::hal::kilobot {

// A pose source that may need to ask the robots who they are. Same thread as the arena.
class RobotMonitor : public PoseSource {
 public:
  // Takes the newest pictures, as far as they have come, and stamps them `now`. Never blocks longer than one picture
  // takes to look at. `now` is monotonic time since the arena was made, never decreasing: it passes while robots are
  // being named, when lab time stands still. The arena stamps and numbers the frames anew; ages are kept.
  virtual void look(LabTime now) = 0;
  // Whether robots are wanted to run from now on, or to stand still; they stand until somebody says so. While they run,
  // or while there is a question, pictures must change: a camera whose pictures stay the same hangs.
  virtual void robots_run(bool run) = 0;
  // The broadcast that the robots should hear now, over and over until this changes; nothing when there is no question.
  virtual std::optional<Message> question() const = 0;
  // Robots that may be somebody else at the moment, ascending: nothing may be said to them by their id.
  virtual std::span<const RobotId> doubtful() const = 0;
  // Every expected robot has been found and named.
  virtual bool everybody_named() const = 0;
  // Why pictures are not used until a person does something about it, one sentence; else empty.
  virtual std::string error() const = 0;
  // Frames lost, tracks lost, swaps suspected, cameras gone, by reason.
  virtual const Counters& counters() const = 0;
};

}  // namespace arkmesh::hal::kilobot
