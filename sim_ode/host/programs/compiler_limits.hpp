// How long a C compiler may take, be it this machine's or the robot's.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <string>

namespace arkmesh::sim_ode {

// A program takes 0.3 s of work. Waiting has a limit apart, since a busy machine may let it wait.
struct CompilerLimits {
  std::chrono::seconds work{60};                              // of processor time, for each start of the compiler
  std::chrono::milliseconds time = std::chrono::minutes(10);  // in all

  // As it follows "not finished after".
  std::string text() const {
    return fmt::format("{} s of work, or {:g} s in all", work.count(), std::chrono::duration<double>(time).count());
  }
};

}  // namespace arkmesh::sim_ode
