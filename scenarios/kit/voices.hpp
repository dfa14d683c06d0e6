// What robots say in the virtual world, heard by robots of all labs: by those within range there (situated
// communication), or by those that a graph joins. A robot says one of a few values, or nothing; what others say is
// known from the boundary on at which their lab has told it.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "hal/types.hpp"
#include "lab/lab.hpp"

namespace arkmesh::scenarios::kit {

class Voices {
 public:
  static constexpr int most_values = 64;

  // The field of states is "kit.<name>". `values`: robots say 0 to values - 1; `range_m` in the shared frame. Throws
  // std::invalid_argument with one sentence.
  Voices(std::string name, int values, double range_m);

  // Robots that hear each other wherever they are: pairs of (lab, robot). Twice the same pair counts once.
  using Robot = std::pair<std::string, hal::RobotId>;
  Voices(std::string name, int values, const std::vector<std::pair<Robot, Robot>>& graph);

  // In the scenario's begin(). Throws std::invalid_argument for a graph with labs that take no part.
  void begin(lab::Lab& lab) const;
  // What a robot of this lab says from now on; negative: nothing. Values that there are not are nothing, too.
  void say(hal::RobotId robot, int value);
  // After the last of a frame: tells others.
  void tell(lab::Lab& lab) const;
  // In on_period.
  void on_period(const lab::Lab& lab);

  // For each robot of a frame and each value, how many others within range say it: own ones as they say it now, those
  // of other labs as merged. Row by row.
  std::vector<int> heard(const lab::Lab& lab, const hal::PoseFrame& frame) const;

 private:
  struct Speaker {
    Robot who;
    hal::Point in_shared;
    int value;
  };
  Voices(std::string name, int values);
  void hear_by_graph(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<int>& counts) const;
  void hear_within_range(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<int>& counts) const;

  std::string field_name_;
  int values_;
  double range_m_ = 0;                       // 0: by graph
  std::map<Robot, std::set<Robot>> joined_;  // each one's neighbours in the graph
  std::map<hal::RobotId, int> own_;
  std::vector<Speaker> others_;  // as merged last, those that say something
};

}  // namespace arkmesh::scenarios::kit
