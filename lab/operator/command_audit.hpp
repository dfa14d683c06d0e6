// The table of commands of operators in the run folder: who wanted what when, and whether it was done.
#pragma once

#include <string_view>

#include "hal/record/recorder.hpp"
#include "hal/time/clock.hpp"

namespace arkmesh::lab {

class CommandAudit {
 public:
  // Both outlive it.
  CommandAudit(hal::Recorder& recorder, const hal::Clock& clock) : recorder_(recorder), clock_(clock) {}

  static constexpr std::string_view admitted = "admitted";
  // `peer`: the lab whose operator it is said to be; empty: the own one. `command`: a word of ours. `outcome`: why it
  // is refused, else that it is admitted; of those refused only the first thousand are in the table.
  void note(std::string_view peer, std::string_view command, std::string_view outcome);

 private:
  hal::Recorder& recorder_;
  const hal::Clock& clock_;
  int refused_ = 0;
};

}  // namespace arkmesh::lab
