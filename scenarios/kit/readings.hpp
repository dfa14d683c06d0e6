// What real sensors do to readings: they are renewed only now and then, and each is a little wrong.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "hal/random.hpp"
#include "hal/types.hpp"

namespace arkmesh::scenarios::kit {

class Readings {
 public:
  struct Column {
    enum class Kind { number, whole_number, angle } kind = Kind::number;  // an angle, in radians, turns round
    double low = 0, high = 0;  // how far its readings may go; beyond, the nearest. Of an angle nothing
    double noise = 0;          // standard deviation of the normal error of a reading, in its unit
  };
  // Renewed each `every_s`; 0: with each frame. A reading below its column's `low` is none, and stays so. `stream`:
  // "lab/purpose", of this sensor alone. Throws std::invalid_argument with one sentence.
  Readings(double every_s, std::vector<Column> columns, std::uint64_t seed, const std::string& stream);

  // Makes the readings of a frame's robots, row by row, what the sensors say. Robots that have none yet get theirs at
  // once. Frames come in time's order.
  void pass(const hal::PoseFrame& frame, std::span<double> readings);

 private:
  hal::LabTime every_;
  std::vector<Column> columns_;
  bool is_perfect_;  // there is nothing to do
  hal::RandomStream random_;
  hal::LabTime renews_at_{0};
  std::map<hal::RobotId, std::vector<double>> held_;
};

}  // namespace arkmesh::scenarios::kit
