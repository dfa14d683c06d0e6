// A testbed's record, played again: what its overhead controller said to the robots, and whether its pictures give the
// poses that the lab saw.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "hal/platforms/kilobot/layout.hpp"
#include "hal/platforms/kilobot/message.hpp"
#include "hal/stop_request.hpp"

namespace arkmesh::app {

// The same message on the air, once or again and again.
struct SaidWord {
  std::int64_t first_us = 0, last_us = 0;  // beginnings, since the record began
  std::uint64_t copies = 0;                // that robots could decode
  std::uint64_t spoilt = 0;                // distorted by bytes on the serial line
  hal::kilobot::Message message;
};

struct PoseComparison {
  std::uint64_t frames = 0;     // compared
  std::uint64_t different = 0;  // of these
  std::uint64_t poses = 0;      // of single robots, compared
  double most_m = 0, most_rad = 0;
  std::string first_difference;  // one sentence; empty: there is none
  std::string ended_by;          // why later frames were not compared, one sentence; empty: all were
  std::string not_compared;      // why none was: the record is of no lab's run; else empty
  bool same() const { return !not_compared.empty() || (frames > 0 && different == 0); }
};

// Poses that differ by less are the same: on another machine a pixel may round otherwise.
inline constexpr double same_within_m = 1e-4, same_within_rad = 1e-3;

struct TestbedRecord {
  std::filesystem::path raw;  // holds serial.txt
  std::filesystem::path run;  // holds config.toml and log.lcm; empty: the record is of a set-up procedure
  bool emulated = false;
  hal::kilobot::WordLayout layout;  // ARK's where no run's configuration names another
};
// `folder` is a run's folder with its record in raw/, or a record. Throws std::runtime_error with one sentence.
TestbedRecord find_testbed_record(const std::filesystem::path& folder);

// Gives each message in order. Throws std::runtime_error with one sentence, also when `stop` is asked.
void replay_words(const TestbedRecord& record, hal::StopRequest& stop,
                  const std::function<void(const SaidWord&)>& said);
// Takes about as long as the run did, or less. Throws as above.
PoseComparison compare_poses(const TestbedRecord& record, hal::StopRequest& stop);

}  // namespace arkmesh::app
