// LCM's datagrams as anybody may write them, honest or not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::tests {

inline void append(std::vector<std::byte>& out, std::uint64_t number, int bytes) {
  while (bytes-- > 0) out.push_back(static_cast<std::byte>(number >> (8 * bytes)));
}
inline void append(std::vector<std::byte>& out, std::string_view text) {
  for (const std::byte b : std::as_bytes(std::span(text))) out.push_back(b);
}

inline std::vector<std::byte> short_datagram(std::string_view channel, std::string_view bytes) {
  std::vector<std::byte> out;
  append(out, "LC02");
  append(out, 0, 4);
  append(out, channel);
  append(out, 0, 1);
  append(out, bytes);
  return out;
}

struct Fragment {
  std::string channel = {};  // of number 0 only
  std::uint32_t sequence = 7, size = 0, offset = 0;
  std::uint16_t number = 0, count = 2;
  std::string bytes = {};
};

inline std::vector<std::byte> fragment(const Fragment& f) {
  std::vector<std::byte> out;
  append(out, "LC03");
  append(out, f.sequence, 4);
  append(out, f.size, 4);
  append(out, f.offset, 4);
  append(out, f.number, 2);
  append(out, f.count, 2);
  if (f.number == 0) {
    append(out, f.channel);
    append(out, 0, 1);
  }
  append(out, f.bytes);
  return out;
}

}  // namespace arkmesh::tests
