// Pheromone in the shared world, laid by robots of all labs. Each lab tells what its own robots have laid since the
// last boundary, and at each boundary all labs lay what all have told, in the order of their names, and let a period
// pass (Lab::grow). So all hold the same field, bit by bit. What is laid is there from the next boundary on; where labs
// do not wait for each other, from the one on at which the owner's lab has told it.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "scenarios/kit/pheromone.hpp"

namespace arkmesh::scenarios::kit {

class SharedPheromone {
 public:
  // Amounts are told in thousandths, in a few bytes for each cell that was laid in: of most_cells at most, in a period
  // and lab.
  static constexpr std::size_t most_cells = 4096;
  static constexpr double least_amount = 0.001, most_amount = 1e6;  // in a cell and period

  // The field of states is "kit.<name>". Sizes and speeds of `settings` are those of the shared frame. Throws as
  // Pheromone does.
  SharedPheromone(std::string name, const Pheromone::Settings& settings);

  // In the scenario's begin().
  void begin(lab::Lab& lab) const;
  // In on_poses: a robot of this lab lays so much where it is. What is too little, too much or in too many cells is
  // counted as "kit.<name>.not_laid", and what is outside the field as "kit.<name>.outside".
  void lay(lab::Lab& lab, const hal::Pose& in_arena, double amount);
  // After the last of a frame: tells what was laid so far.
  void tell(lab::Lab& lab) const;
  // In on_period. Where labs do not wait for each other, states may be skipped: "kit.<name>.missed" counts the periods
  // whose pheromone did not come, "kit.<name>.malformed" states of which the rest makes no sense.
  void on_period(lab::Lab& lab);

  const Pheromone& field() const { return field_; }
  // A robot as the field has it.
  static hal::Pose in_field(const lab::Lab& lab, const hal::Pose& in_arena) {
    return lab.projection().to_shared(in_arena);
  }

 private:
  void lay_told(lab::Lab& lab, std::span<const std::int64_t> told);

  std::string name_, field_name_;
  Pheromone field_;
  std::map<int, std::int64_t> laid_;           // in thousandths, by cell, since the last boundary
  std::map<std::string, std::uint32_t> told_;  // newest period applied, by lab
};

}  // namespace arkmesh::scenarios::kit
