// The table of commands of operators in the run folder: who wanted what when, and whether it was done.
#pragma once

#include <string>
#include <string_view>

#include "hal/record/recorder.hpp"
#include "hal/time/clock.hpp"

namespace arkmesh::lab {

class CommandAudit {
 public:
  // Both outlive it.
  CommandAudit(hal::Recorder& recorder, const hal::Clock& clock) : recorder_(recorder), clock_(clock) {}

  // `peer`: the lab whose operator it is said to be; empty: the own one. `command`: of the message; -1: it has none.
  void admitted(const std::string& peer, int command);
  // The first thousand of them.
  void refused(const std::string& peer, int command, std::string_view why);
  // The same of what was no message: `command` in a word of ours, which goes into the table as it is.
  void refused(const std::string& peer, std::string_view command, std::string_view why);

 private:
  void row(std::string_view peer, std::string_view command, std::string_view outcome);

  hal::Recorder& recorder_;
  const hal::Clock& clock_;
  int refused_ = 0;
};

}  // namespace arkmesh::lab
