// The keys of [safety]: when robots of a lab obey others, and when they stop by themselves.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "hal/config.hpp"

namespace arkmesh::lab {

struct SafetyConfig {
  std::vector<std::string> commands_from;  // labs whose operators may pause and resume robots here, and end the run
  double commands_per_s = 1;               // of each of them, at most
  // Robots that keep real time pause when no new state of any peer was applied for so long; 0: never.
  std::chrono::microseconds pause_after{10'000'000};

  void fields(const hal::Section& safety);
  // `labs`: shared.labs, `lab` included.
  void check(const hal::Section& safety, const std::string& lab, const std::vector<std::string>& labs) const;
};

}  // namespace arkmesh::lab
