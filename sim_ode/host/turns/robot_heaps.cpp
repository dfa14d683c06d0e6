#include "sim_ode/host/turns/robot_heaps.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

namespace arkmesh::sim_ode {
namespace {

constexpr std::byte gap_byte{0xA5};
constexpr std::size_t most_misuse = 1000;  // kept until somebody takes it

std::size_t page_bytes() {
  return static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

RobotHeaps::~RobotHeaps() {
  if (place_) munmap(place_ - page_bytes(), mapped_ + 2 * page_bytes());
}

// A page before and one behind cannot be touched.
void RobotHeaps::map() {
  const std::size_t page = page_bytes();
  mapped_ = (bytes_ + page - 1) / page * page;
  void* const all = mmap(nullptr, mapped_ + 2 * page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (all == MAP_FAILED) return;
  std::byte* const place = static_cast<std::byte*>(all) + page;
  if (mprotect(place, mapped_, PROT_READ | PROT_WRITE) == 0)
    place_ = place;
  else
    munmap(all, mapped_ + 2 * page);
}

void RobotHeaps::mark_gap(const Block& block) const {
  std::fill(place_ + block.at + block.bytes, place_ + block.at + room(block.bytes), gap_byte);
}

bool RobotHeaps::gap_is_whole(const Block& block) const {
  return std::all_of(place_ + block.at + block.bytes, place_ + block.at + room(block.bytes),
                     [](std::byte b) { return b == gap_byte; });
}

void RobotHeaps::look_behind(int robot, Block& block, const void* noticed) {
  if (block.spoiled || gap_is_whole(block)) return;
  block.spoiled = true;
  if (misuse_.size() < most_misuse) misuse_.push_back({robot, block.bytes, block.from, noticed});
}

void* RobotHeaps::reallocate(int robot, void* old, std::size_t bytes, const void* from) {
  if (!place_) map();
  if (!place_) return nullptr;
  Heap& heap = heaps_[static_cast<std::size_t>(robot)];
  auto mine = heap.blocks.end();
  if (old) {
    mine = std::ranges::find(heap.blocks, static_cast<std::byte*>(old), [&](const Block& b) { return place_ + b.at; });
    if (mine == heap.blocks.end()) {
      if (misuse_.size() < most_misuse) misuse_.push_back({robot, 0, nullptr, from});
      return nullptr;
    }
    look_behind(robot, *mine, from);
    if (bytes == 0) {
      heap.blocks.erase(mine);
      return nullptr;
    }
    const std::size_t end = mine + 1 == heap.blocks.end() ? bytes_ : (mine + 1)->at;
    if (bytes < bytes_ && mine->at + room(bytes) <= end) {
      *mine = {mine->at, bytes, from};
      mark_gap(*mine);
      heap.extent = std::max(heap.extent, mine->at + room(bytes));
      extent_ = std::max(extent_, heap.extent);
      return old;
    }
  }
  if (bytes >= bytes_) return nullptr;

  // the first place that is large enough
  std::size_t at = 0;
  auto next = heap.blocks.begin();
  for (; next != heap.blocks.end() && next->at - at < room(bytes); ++next) at = next->at + room(next->bytes);
  if (at + room(bytes) > bytes_) return nullptr;
  const std::size_t moved = old ? std::min(mine->bytes, bytes) : 0;
  if (old) std::memmove(place_ + at, old, moved);
  const Block block{at, bytes, from};
  mark_gap(block);
  heap.extent = std::max(heap.extent, at + room(bytes));
  extent_ = std::max(extent_, heap.extent);
  const std::size_t leaves = old ? mine->at : bytes_;
  heap.blocks.insert(next, block);
  std::erase_if(heap.blocks, [&](const Block& b) { return b.at == leaves; });
  return place_ + at;
}

void RobotHeaps::enter(int robot) {
  const Heap& heap = heaps_[static_cast<std::size_t>(robot)];
  if (heap.extent > 0) std::memcpy(place_, heap.image.data(), heap.extent);
  if (heap.extent < extent_) std::memset(place_ + heap.extent, 0, extent_ - heap.extent);
  extent_ = heap.extent;
}

void RobotHeaps::leave(int robot) {
  Heap& heap = heaps_[static_cast<std::size_t>(robot)];
  bool spoiled = false;
  for (Block& block : heap.blocks) {
    look_behind(robot, block, nullptr);
    spoiled = spoiled || block.spoiled;
  }
  if (spoiled) {  // what it wrote beyond all is its own, too
    std::size_t end = mapped_;
    while (end > heap.extent && place_[end - 1] == std::byte{0}) --end;
    heap.extent = end;
  }
  extent_ = std::max(extent_, heap.extent);
  if (heap.image.size() < heap.extent) heap.image.resize(mapped_);
  if (heap.extent > 0) std::memcpy(heap.image.data(), place_, heap.extent);
}

void RobotHeaps::forget(int robot) {
  heaps_[static_cast<std::size_t>(robot)] = {};
  enter(robot);
}

}  // namespace arkmesh::sim_ode
