#include "gateway/compression.hpp"

#include <zstd.h>

#include <boost/endian/conversion.hpp>
#include <cstdint>

namespace arkmesh::gateway {

namespace {

constexpr std::size_t length_bytes = 4;
// The fastest of zstd's usual ones: a gateway carries live data.
constexpr int compression_level = 1;

}  // namespace

std::vector<std::byte> compress(std::span<const std::byte> bytes) {
  // Room for less than the bytes themselves: zstd gives up when it needs more.
  if (bytes.size() <= length_bytes + 1 || bytes.size() > UINT32_MAX) return {};
  std::vector<std::byte> out(bytes.size() - 1);
  boost::endian::store_big_u32(reinterpret_cast<unsigned char*>(out.data()), static_cast<std::uint32_t>(bytes.size()));
  const std::size_t size = ZSTD_compress(out.data() + length_bytes, out.size() - length_bytes, bytes.data(),
                                         bytes.size(), compression_level);
  if (ZSTD_isError(size) != 0) return {};
  out.resize(length_bytes + size);
  out.shrink_to_fit();
  return out;
}

std::optional<std::vector<std::byte>> decompress(std::span<const std::byte> packed, std::size_t max_bytes) {
  if (packed.size() < length_bytes) return {};
  const std::size_t length = boost::endian::load_big_u32(reinterpret_cast<const unsigned char*>(packed.data()));
  if (length > max_bytes) return {};
  packed = packed.subspan(length_bytes);
  std::vector<std::byte> out(length);
  const std::size_t size = ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size());
  if (ZSTD_isError(size) != 0 || size != length) return {};
  return out;
}

}  // namespace arkmesh::gateway
