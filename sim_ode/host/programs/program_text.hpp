// What robots print, on its way from their programs to whoever shows it. Bounded; knows nothing of lines.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace arkmesh::sim_ode {

class ProgramText {
 public:
  struct Piece {
    int robot;
    std::int64_t at_us;  // lab time
    std::string text;
  };

  ProgramText() : bytes_(max_bytes) { pieces_.reserve(max_pieces); }

  // May be called from inside program code, which can be left at any instruction: allocates nothing.
  void say(int robot, std::int64_t at_us, const char* text, std::uint32_t size) noexcept;

  // All that was said since the last call, in order.
  std::vector<Piece> take();
  // Characters that found no room since the beginning, because nobody took what was there.
  std::uint64_t lost() const { return lost_; }

 private:
  static constexpr std::size_t max_bytes = 1 << 20, max_pieces = 1 << 16;
  struct Place {
    int robot;
    std::uint32_t size;
    std::int64_t at_us;
  };
  std::vector<char> bytes_;
  std::size_t used_ = 0;
  std::vector<Place> pieces_;
  std::uint64_t lost_ = 0;
};

}  // namespace arkmesh::sim_ode
