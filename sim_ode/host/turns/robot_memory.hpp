// All robots' copies of a program's writable memory. The program itself has one place for it; a robot's copy is put
// there for the robot's turn and taken back afterwards.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <span>

#include "sim_ode/host/turns/robot_heaps.hpp"

namespace arkmesh::sim_ode {

class RobotMemory {
 public:
  // `place` is where the program looks, `first` what it finds there before its first instruction: a multiple of 64
  // bytes, which outlive the memory. Copies are zeros at first.
  RobotMemory(char* place, std::span<const std::byte> first, int robots)
      : place_(place),
        bytes_(first.size()),
        first_(first),
        all_(static_cast<std::byte*>(
            ::operator new (bytes_* static_cast<std::size_t>(robots) + line, std::align_val_t{line}))) {
    std::memset(all_.get(), 0, bytes_ * static_cast<std::size_t>(robots));
  }

  // Puts the first memory in place, as at power-up.
  void start_anew() const { copy(reinterpret_cast<std::byte*>(place_), first_.data()); }

  void copy_in(int robot) const {
    copy(reinterpret_cast<std::byte*>(place_), of(robot));
    if (heaps_) [[unlikely]]
      heaps_->enter(robot);
  }
  void copy_out(int robot) {
    copy(of(robot), reinterpret_cast<const std::byte*>(place_));
    if (heaps_) [[unlikely]]
      heaps_->leave(robot);
  }
  // From now on robots have these, too; they outlive the memory.
  void use(RobotHeaps& heaps) { heaps_ = &heaps; }
  // Says that copy_in comes soon.
  void fetch(int robot) const {
    for (std::size_t at = 0; at < bytes_; at += line) __builtin_prefetch(of(robot) + at);
  }

  // A robot's copy of a variable, given where the program has it.
  template <class T>
  T read(int robot, const volatile T* variable) const {
    T value;
    std::memcpy(&value, of(robot) + offset(variable), sizeof value);
    return value;
  }
  template <class T>
  void write(int robot, const volatile T* variable, T value) {
    std::memcpy(of(robot) + offset(variable), &value, sizeof value);
  }

 private:
  static constexpr std::size_t line = 64;  // of the cache; copies that share no lines are cheaper
  struct Free {
    void operator()(std::byte* memory) const { ::operator delete (memory, std::align_val_t{line}); }
  };
  std::byte* of(int robot) const { return all_.get() + bytes_ * static_cast<std::size_t>(robot); }
  std::size_t offset(const volatile void* variable) const {
    return static_cast<std::size_t>(static_cast<const volatile char*>(variable) - place_);
  }
  // In small pieces: the processor then need not wait until what was written last has reached its cache.
  void copy(std::byte* to, const std::byte* from) const {
    const std::size_t bytes = bytes_;  // what is written might be this, as far as the compiler knows
    for (std::size_t at = 0; at < bytes; at += line) std::memcpy(to + at, from + at, line);
  }

  char* place_;
  std::size_t bytes_;
  std::span<const std::byte> first_;
  RobotHeaps* heaps_ = nullptr;
  std::unique_ptr<std::byte, Free> all_;
};

}  // namespace arkmesh::sim_ode
