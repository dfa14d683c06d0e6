// Stacks for programs: small, many, each fenced on both sides. Reused, never shrunk.
#pragma once

#include <cstddef>
#include <vector>

#include "sim_ode/host/turns/context_switch.hpp"

namespace arkmesh::sim_ode {

class ProgramStacks {
 public:
  // Lower end is `top - bytes`; stacks grow down from top.
  struct Stack {
    char* top;
    std::size_t bytes;
    StackBounds bounds() const { return {top - bytes, bytes}; }
    // Whether an address lies in the fence below it (-1), in the one above it (1), or elsewhere (0).
    int fence_at(const void* address) const;
  };

  ProgramStacks() = default;
  ~ProgramStacks();
  ProgramStacks(const ProgramStacks&) = delete;
  ProgramStacks& operator=(const ProgramStacks&) = delete;

  // Throws std::bad_alloc when the system gives no more memory.
  const Stack* take();
  void give(const Stack* stack) { free_.push_back(stack); }

 private:
  struct Slab {
    char* memory;
    std::vector<Stack> stacks;
  };
  void grow();
  std::vector<Slab> slabs_;
  std::vector<const Stack*> free_;
};

}  // namespace arkmesh::sim_ode
