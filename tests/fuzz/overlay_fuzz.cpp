// Arbitrary bytes as an `overlay`: check, decode, bound. Nothing may crash, hang or take much memory, and what was
// taken must survive its own message.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "hal/overlay/drawing_message.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace arkmesh::hal;
  Drawing drawing;
  Counters refused;
  if (!read_overlay(std::span(reinterpret_cast<const std::byte*>(data), size), drawing, refused)) return 0;
  const arkmesh::overlay_t message = to_message(drawing, LabTime{1});
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  Drawing again;
  Counters none;
  if (!read_overlay(bytes, again, none) || again.size() != drawing.size() || !none.all().empty()) std::abort();
  return 0;
}
