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

  // Of a message; of -1, of none, empty.
  static std::string word_of(int command);
  // `peer`: the lab whose operator it is said to be; empty: the own one. `command`: a word of ours, as the table has
  // it.
  void admitted(const std::string& peer, std::string_view command);
  // The first thousand of them.
  void refused(const std::string& peer, std::string_view command, std::string_view why);

 private:
  void row(std::string_view peer, std::string_view command, std::string_view outcome);

  hal::Recorder& recorder_;
  const hal::Clock& clock_;
  int refused_ = 0;
};

}  // namespace arkmesh::lab
