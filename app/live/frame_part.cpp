#include "app/live/frame_part.hpp"

#include <boost/endian/conversion.hpp>

#include "arkmesh/pose_frame_t.hpp"
#include "hal/arenas/messages.hpp"

namespace arkmesh::app {

std::optional<FramePart> frame_part(std::string_view channel, std::span<const std::byte> bytes) {
  // fingerprint, stamp_us, number, part, parts
  if (channel != hal::channel::poses || bytes.size() < 8 + 8 + 3 * 4) return {};
  const auto* const at = reinterpret_cast<const unsigned char*>(bytes.data());
  using boost::endian::load_big_s32, boost::endian::load_big_s64;
  if (load_big_s64(at) != pose_frame_t::getHash()) return {};
  const FramePart out{load_big_s64(at + 8), {load_big_s32(at + 16), load_big_s32(at + 20), load_big_s32(at + 24)}};
  if (out.stamp_us < 0 || out.part.part < 0 || out.part.part >= out.part.parts) return {};
  return out;
}

}  // namespace arkmesh::app
