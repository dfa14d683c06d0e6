// A record's pictures before the same eyes that the lab had, at the recorded times: the poses come out again. Knows
// neither the lab's log nor its robots' controller.
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/platforms/kilobot/robot_monitor.hpp"
#include "testbed/kilobot_settings.hpp"
#include "testbed/raw_folder.hpp"

namespace arkmesh::testbed {

class PoseReplay {
 public:
  // `settings` are the lab's, with the calibrations that the folder holds. Throws RecordError.
  PoseReplay(std::filesystem::path folder, const KilobotSettings& settings);
  ~PoseReplay();

  struct Seen {
    hal::LabTime now{0};                  // of the look, since the arena was made
    std::optional<FrameLine> taken;       // as what the lab took the poses, if it did
    std::optional<hal::PoseFrame> poses;  // before the arena has numbered and bounded them
  };
  // The next look. Nothing at the end, or from the first picture on that is not there. Throws RecordError.
  std::optional<Seen> next();
  // Why there are no more, one sentence; empty when the record ends there.
  const std::string& ended_by() const { return ended_by_; }

 private:
  struct Pictures;
  bool show(const LookLine& look);

  std::filesystem::path folder_;
  std::ifstream file_;
  LookLines lines_;
  std::unique_ptr<Pictures> pictures_;
  std::unique_ptr<hal::kilobot::RobotMonitor> eyes_;
  std::optional<LookLine> ahead_;
  std::string ended_by_;
};

}  // namespace arkmesh::testbed
