// Room is taken once, at the beginning.
#include "sim_ode/host/programs/program_text.hpp"

#include <cstring>

namespace arkmesh::sim_ode {

void ProgramText::say(int robot, std::int64_t at_us, const char* text, std::uint32_t size) noexcept {
  if (used_ + size > max_bytes || pieces_.size() == max_pieces) {
    lost_ += size;
    return;
  }
  std::memcpy(bytes_.data() + used_, text, size);
  used_ += size;
  pieces_.push_back({robot, size, at_us});
}

std::vector<ProgramText::Piece> ProgramText::take() {
  std::vector<Piece> out;
  out.reserve(pieces_.size());
  const char* at = bytes_.data();
  for (const Place& place : pieces_) {
    out.push_back({place.robot, place.at_us, std::string(at, place.size)});
    at += place.size;
  }
  pieces_.clear();
  used_ = 0;
  return out;
}

}  // namespace arkmesh::sim_ode
