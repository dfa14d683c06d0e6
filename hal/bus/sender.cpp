#include "hal/bus/sender.hpp"

#include <boost/endian/conversion.hpp>

#include "hal/bus/channel_names.hpp"

namespace arkmesh::hal {

std::optional<Sender> read_sender(std::span<const std::byte> bytes, std::int64_t fingerprint) {
  const auto* at = reinterpret_cast<const unsigned char*>(bytes.data());
  if (bytes.size() < 12 || boost::endian::load_big_s64(at) != fingerprint) return {};
  const std::uint32_t length = boost::endian::load_big_u32(at + 8);  // counts the final zero
  if (length < 2 || length > max_lab_name + 1 || bytes.size() < 12 + length + 8) return {};
  Sender sender{{reinterpret_cast<const char*>(at) + 12, length - 1}, boost::endian::load_big_u64(at + 12 + length)};
  if (!is_lab_name(sender.lab)) return {};
  return sender;
}

}  // namespace arkmesh::hal
