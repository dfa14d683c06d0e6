// Intel HEX from anywhere: text as it is, or records whose checksums are made right, because the fuzzer would hardly
// guess them. Whatever comes, it ends in one sentence with the file's name or in a program whose pages, written as HEX
// again, read the same.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>

#include "hal/platforms/kilobot/intel_hex.hpp"

namespace {

using namespace arkmesh::hal::kilobot;

void require(bool condition) {
  if (!condition) std::abort();
}

void put(std::string& text, std::uint8_t byte) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  text += digits[byte >> 4];
  text += digits[byte & 15];
}

// One record with a right length and checksum.
void put_record(std::string& text, std::uint8_t type, unsigned address, std::span<const std::uint8_t> data) {
  text += ':';
  std::uint8_t sum = 0;
  const auto add = [&](unsigned byte) {
    put(text, static_cast<std::uint8_t>(byte));
    sum = static_cast<std::uint8_t>(sum + byte);
  };
  add(static_cast<unsigned>(data.size()));
  add(address >> 8 & 0xFF);
  add(address & 0xFF);
  add(type);
  for (const std::uint8_t byte : data) add(byte);
  put(text, static_cast<std::uint8_t>(-sum));
  text += '\n';
}

// Records from bytes: type, two of address, length, data.
std::string records(std::span<const std::uint8_t> bytes) {
  std::string text;
  while (bytes.size() >= 4) {
    const std::size_t length = std::min<std::size_t>(bytes[3], bytes.size() - 4);
    put_record(text, bytes[0] % 7, static_cast<unsigned>(bytes[1]) << 8 | bytes[2], bytes.subspan(4, length));
    bytes = bytes.subspan(4 + length);
  }
  put_record(text, 1, 0, {});
  return text;
}

void read(std::string_view text) {
  try {
    const Firmware firmware = parse_intel_hex(text, "fuzz.hex");
    require(firmware.size_bytes() >= 1 && firmware.size_bytes() <= max_program_bytes);
    require(firmware.pages() >= 1 && firmware.pages() <= max_pages);
    require(firmware.size_bytes() <= static_cast<std::size_t>(firmware.pages()) * page_bytes);
    std::string again;
    for (int page = 0; page < firmware.pages(); ++page)
      put_record(again, 0, static_cast<unsigned>(page) * page_bytes, firmware.page(page));
    put_record(again, 1, 0, {});
    const Firmware same = parse_intel_hex(again, "again.hex");
    for (int page = 0; page < firmware.pages(); ++page)
      require(std::ranges::equal(firmware.page(page), same.page(page)));
  } catch (const FirmwareError& error) {
    const std::string_view said = error.what();
    require(said.starts_with("fuzz.hex:") && said.find('\n') == std::string_view::npos);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span bytes(data, size);
  if (data[0] % 2 == 0)
    read({reinterpret_cast<const char*>(data) + 1, size - 1});
  else
    read(records(bytes.subspan(1)));
  return 0;
}
