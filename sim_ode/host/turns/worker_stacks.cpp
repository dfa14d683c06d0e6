// Slabs of 64 stacks from mmap. Each stack has a fence page below it, until the kernel's limit on mappings comes near;
// from then on only each slab has one.
#include "sim_ode/host/turns/worker_stacks.hpp"

#include <sys/mman.h>

#include <new>

namespace arkmesh::sim_ode {
namespace {

constexpr std::size_t page = 4096;
// Programs were seen to use 5 kB at most; a robot has 2 kB in all. Instrumented hosts need more.
#if ARKMESH_ADDRESS_SANITIZER
constexpr std::size_t usable = 64 * 1024;
#else
constexpr std::size_t usable = 16 * 1024;
#endif
constexpr std::size_t per_slab = 64;
// Two mappings for each fenced stack; the kernel allows 65530 in all.
constexpr std::size_t max_fenced_slabs = 20'000 / per_slab;

}  // namespace

WorkerStacks::~WorkerStacks() {
  for (const Slab& slab : slabs_) munmap(slab.memory, per_slab * (usable + page));
}

const WorkerStacks::Stack* WorkerStacks::take() {
  if (free_.empty()) grow();
  const Stack* stack = free_.back();
  free_.pop_back();
  forget_frames(stack->bounds());
  return stack;
}

void WorkerStacks::grow() {
  void* memory = mmap(nullptr, per_slab * (usable + page), PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  const bool fenced = slabs_.size() < max_fenced_slabs;
  Slab& slab = slabs_.emplace_back();
  slab.memory = static_cast<char*>(memory);
  slab.stacks.reserve(per_slab);
  for (std::size_t k = 0; k < per_slab; ++k) {
    char* const fence = slab.memory + k * (usable + page);
    if (k == 0 || fenced) mprotect(fence, page, PROT_NONE);
    // tops at different places in their pages do not fight for the same cache sets
    const std::size_t stagger = k * 64 % page;
    slab.stacks.push_back({fence + page + usable - stagger, usable - stagger});
  }
  for (std::size_t k = per_slab; k-- > 0;) free_.push_back(&slab.stacks[k]);
}

bool WorkerStacks::is_fence(const void* address) const {
  for (const Slab& slab : slabs_) {
    const auto offset = static_cast<const char*>(address) - slab.memory;
    if (offset < 0 || static_cast<std::size_t>(offset) >= per_slab * (usable + page)) continue;
    return static_cast<std::size_t>(offset) % (usable + page) < page;
  }
  return false;
}

}  // namespace arkmesh::sim_ode
