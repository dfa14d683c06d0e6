// What malloc() gives robots' programs: each robot its own memory, bounded, at the place where all robots of the
// program see theirs, exchanged with the turn as far as it is used. Who has which part of it is kept apart, so that a
// program that writes beyond its parts damages its own data only, as on a robot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace arkmesh::sim_ode {

class RobotHeaps {
 public:
  // What a program did that on a robot would go unseen.
  struct Misuse {
    int robot;
    std::size_t bytes;    // of the block that it wrote beyond; 0: it gave back what it did not have
    const void* from;     // who asked for that block
    const void* noticed;  // where it called; null: when its turn ended
  };

  // Takes no memory before the first request.
  RobotHeaps(std::size_t bytes, int robots) : bytes_(bytes), heaps_(static_cast<std::size_t>(robots)) {}
  ~RobotHeaps();
  RobotHeaps(const RobotHeaps&) = delete;
  RobotHeaps& operator=(const RobotHeaps&) = delete;

  // As realloc(), for the robot whose turn it is; 0 bytes: as free(). Null: there is no room.
  void* reallocate(int robot, void* old, std::size_t bytes, const void* from);
  bool in_use() const { return place_ != nullptr; }

  // The robot's turn begins, ends; it is powered up.
  void enter(int robot);
  void leave(int robot);
  void forget(int robot);

  // Since the last call.
  std::vector<Misuse> take_misuse() { return std::exchange(misuse_, {}); }

 private:
  struct Block {
    std::size_t at, bytes;
    const void* from;
    bool spoiled = false;  // somebody wrote behind it
  };
  struct Heap {
    std::vector<Block> blocks;     // by place
    std::vector<std::byte> image;  // while others have their turn
    std::size_t extent = 0;        // bytes from the beginning that may be other than zero
  };
  // With what is behind a block, to see whether it was written to.
  static constexpr std::size_t least_gap = 8;
  static std::size_t room(std::size_t bytes) { return (bytes + 7) / 8 * 8 + least_gap; }

  void map();
  void mark_gap(const Block& block) const;
  bool gap_is_whole(const Block& block) const;
  void look_behind(int robot, Block& block, const void* noticed);

  const std::size_t bytes_;
  std::size_t mapped_ = 0;
  std::byte* place_ = nullptr;
  std::size_t extent_ = 0;  // of what is in place; all behind is zero
  std::vector<Heap> heaps_;
  std::vector<Misuse> misuse_;
};

}  // namespace arkmesh::sim_ode
