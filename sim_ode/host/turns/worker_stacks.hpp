// Stacks for programs that wait inside delay(): small, many, each fenced. Reused, never shrunk.
#pragma once

#include <cstddef>
#include <vector>

#include "sim_ode/host/turns/context_switch.hpp"

namespace arkmesh::sim_ode {

class WorkerStacks {
 public:
  // Lower end is `top - bytes`; stacks grow down from top.
  struct Stack {
    char* top;
    std::size_t bytes;
    StackBounds bounds() const { return {top - bytes, bytes}; }
  };

  WorkerStacks() = default;
  ~WorkerStacks();
  WorkerStacks(const WorkerStacks&) = delete;
  WorkerStacks& operator=(const WorkerStacks&) = delete;

  // Throws std::bad_alloc when the system gives no more memory.
  const Stack* take();
  void give(const Stack* stack) { free_.push_back(stack); }
  // Whether an address lies in the fence below one of our stacks.
  bool is_fence(const void* address) const;

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
