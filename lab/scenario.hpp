// A task that swarms play in a shared world. One folder each below scenarios/; one line in app/scenarios.cpp.
#pragma once

#include <chrono>
#include <span>

#include "lab/lab.hpp"

namespace arkmesh::lab {

class Scenario {
 public:
  virtual ~Scenario() = default;
  // Once, before lab time passes: declares fields, and publishes what this lab decides (the owner: shared things).
  // Peers' states are not there yet.
  virtual void begin(Lab& lab) = 0;
  // For each new pose frame, in time order. States of all labs are those merged at the last boundary; frame 0 comes
  // before the first merge, when lab.state() is not there yet: say nothing then.
  virtual void on_poses(Lab& lab, const hal::PoseFrame& frame) = 0;
  // What robots said since the last call, in the order in which it was heard; never for Kilobots. After on_poses when a
  // frame came with it; what both say goes out together. Before the first merge, too: say nothing then.
  virtual void on_heard(Lab& lab, std::span<const hal::FromRobot> messages) = 0;
  // At each boundary, right after the states were merged; period 0 first.
  virtual void on_period(Lab& lab) = 0;
  // Whether it has said all that it has to say to the last call. One that computes elsewhere says false until then, for
  // each of the calls above but begin(); its lab, if its arena can wait, calls nothing else meanwhile, and serves peers
  // and operators. Waits at most so long.
  virtual bool settled(Lab& lab, std::chrono::milliseconds wait) {
    (void)lab, (void)wait;
    return true;
  }
  // A function of the merged states only, asked after on_period; the first boundary at which it is true is the last
  // one.
  virtual bool finished(const Lab& lab) const = 0;
};

}  // namespace arkmesh::lab
