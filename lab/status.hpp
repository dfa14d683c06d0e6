// A lab's sign of life: channel `status`.
#pragma once

#include <string>

#include "arkmesh/lab_status_t.hpp"

namespace arkmesh::lab {

class Runner;

// What a lab is doing, in words: for whom or what it waits, else what it does.
struct StateText {
  std::string does = "starting", waits;

  void goes_on() { waits.clear(); }
  void has_merged() {
    if (does == "starting") does = "running";
    goes_on();
  }
  const std::string& text() const { return waits.empty() ? does : waits; }
};

// The lab as it is now; the scenario's totals are in it as "counts.NAME".
lab_status_t status_of(const Runner& run);

}  // namespace arkmesh::lab
