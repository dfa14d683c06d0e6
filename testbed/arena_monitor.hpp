// The eyes of a testbed of real Kilobots: newest pictures of all cameras in, named robots out. Puts tracker and
// identity together.
#pragma once

#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "hal/platforms/kilobot/robot_monitor.hpp"
#include "testbed/kilobot_settings.hpp"
#include "tracker/camera/live_camera.hpp"
#include "tracker/follow/arena_tracker.hpp"
#include "tracker/identity/name_keeper.hpp"

namespace arkmesh::testbed {

// Called after each look with what was seen, for people who watch: pictures[i] is camera i's, empty when it gave
// nothing new.
struct Look {
  hal::LabTime now{0};
  std::span<const cv::Mat> pictures;
  std::span<const hal::LabTime> arrived;  // of each camera's last picture, by the time of looks
  const tracker::ArenaTracker& tracker;
  hal::Counters& counters;  // among which who watches may keep totals of its own
};
using Observer = std::function<void(const Look&)>;

// Opens the cameras; one that is not there is waited for. `names`: who finds out who is who, in place of what the
// settings say.
//
// Counts what ArenaTracker, the identifier and the cameras count, and camera.same_picture (pictures equal to the one
// before; they are used), camera.frozen (those that are not, since the camera must hang: see HungCamera),
// frame.no_picture (looks for which no camera had anything new that could be believed), and what PlacedCamera counts.
std::unique_ptr<hal::kilobot::RobotMonitor> make_arena_monitor(const KilobotSettings& settings, Observer observer = {},
                                                               const tracker::OpenCamera& open = tracker::open_camera,
                                                               std::unique_ptr<tracker::NameKeeper> names = nullptr);

}  // namespace arkmesh::testbed
