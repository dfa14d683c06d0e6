// Slabs of 64 stacks from mmap, with a fence below and above each, until the kernel's limit on mappings comes near;
// from then on only a slab has them.
#include "sim_ode/host/turns/program_stacks.hpp"

#include <sys/mman.h>

#include <new>

namespace arkmesh::sim_ode {
namespace {

// Programs were seen to use 5 kB at most; a robot has 2 kB in all. Instrumented hosts need more.
#if ARKMESH_ADDRESS_SANITIZER
constexpr std::size_t usable = 64 * 1024;
#else
constexpr std::size_t usable = 16 * 1024;
#endif
// As far as an index of 16 bits reaches. An odd number of pages, so that stacks' tops do not fight for the same cache
// sets.
constexpr std::size_t fence = 17 * 4096, each = fence + usable;
constexpr std::size_t spare = 16;  // zeros above the top, for who looks there for a caller
constexpr std::size_t per_slab = 64, slab_bytes = per_slab * each + fence;
// Two mappings for each fenced stack; the kernel allows 65530 in all.
constexpr std::size_t max_fenced_slabs = 20'000 / per_slab;

}  // namespace

int ProgramStacks::Stack::fence_at(const void* address) const {
  const std::ptrdiff_t above = static_cast<const char*>(address) - top;
  const auto size = static_cast<std::ptrdiff_t>(fence), below = -above - static_cast<std::ptrdiff_t>(bytes);
  if (below > 0 && below <= size) return -1;
  return above >= 0 && above < size ? 1 : 0;
}

ProgramStacks::~ProgramStacks() {
  for (const Slab& slab : slabs_) munmap(slab.memory, slab_bytes);
}

const ProgramStacks::Stack* ProgramStacks::take() {
  if (free_.empty()) grow();
  const Stack* stack = free_.back();
  free_.pop_back();
  forget_frames(stack->bounds());
  return stack;
}

void ProgramStacks::grow() {
  void* memory = mmap(nullptr, slab_bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  Slab& slab = slabs_.emplace_back();
  slab.memory = static_cast<char*>(memory);
  slab.stacks.reserve(per_slab);
  const bool fenced = slabs_.size() <= max_fenced_slabs;
  if (!fenced) mprotect(slab.memory + fence, slab_bytes - 2 * fence, PROT_READ | PROT_WRITE);
  for (std::size_t k = 0; k < per_slab; ++k) {
    char* const bottom = slab.memory + fence + k * each;
    if (fenced) mprotect(bottom, usable, PROT_READ | PROT_WRITE);
    slab.stacks.push_back({bottom + usable - spare, usable - spare});
  }
  for (std::size_t k = per_slab; k-- > 0;) free_.push_back(&slab.stacks[k]);
}

}  // namespace arkmesh::sim_ode
