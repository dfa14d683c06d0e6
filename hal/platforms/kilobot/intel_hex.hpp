// Robot programs as avr-gcc's tool chain writes them: Intel HEX. Reads and checks; nothing is sent here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "hal/platforms/kilobot/packet.hpp"

namespace arkmesh::hal::kilobot {

inline constexpr int max_pages = 220;                                     // a boot loader takes no more
inline constexpr std::size_t max_program_bytes = max_pages * page_bytes;  // 28160

// One sentence: file, line, what is wrong and what to do.
class FirmwareError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The contents of a robot's flash from address 0.
class Firmware {
 public:
  // `bytes` is not empty and at most max_program_bytes long.
  explicit Firmware(std::vector<std::uint8_t> bytes);
  // As kilogui counts: one more than there are full pages, at most 220.
  int pages() const { return pages_; }
  // Bytes that no record sets are zero. 0 <= page < pages().
  std::span<const std::uint8_t, page_bytes> page(int page) const;
  // From address 0 to the last byte set.
  std::size_t size_bytes() const { return size_bytes_; }

 private:
  std::size_t size_bytes_;
  int pages_;
  std::vector<std::uint8_t> bytes_;  // whole pages
};

// Record types 00 to 05 (start addresses are ignored: robots start at 0). Throws FirmwareError.
Firmware parse_intel_hex(std::string_view text, std::string_view file);
Firmware read_intel_hex(const std::filesystem::path& file);

}  // namespace arkmesh::hal::kilobot
