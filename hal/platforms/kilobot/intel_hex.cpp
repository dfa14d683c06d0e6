// One record a line: ":", byte count, address, type, data, checksum, all as pairs of hexadecimal digits.
#include "hal/platforms/kilobot/intel_hex.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "hal/counted.hpp"

namespace arkmesh::hal::kilobot {
namespace {

constexpr std::size_t max_file_bytes = 1 << 20;  // the largest program takes 80 kB

int digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

class Reader {
 public:
  explicit Reader(std::string_view file) : file_(file), bytes_(max_program_bytes), is_set_(max_program_bytes) {}

  Firmware read(std::string_view text) {
    while (!text.empty()) {
      ++line_;
      const std::size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
      if (!line.empty()) read_record(line);
    }
    if (line_ == 0) throw FirmwareError(fmt::format("{}: the file is empty", file_));
    if (!ended_)
      refuse("the file ends without its end record (:00000001FF), so a part is missing; build or copy it again");
    if (size_ == 0) refuse("the file holds no program");
    bytes_.resize(size_);
    return Firmware(std::move(bytes_));
  }

 private:
  [[noreturn]] void refuse(std::string_view sentence) const {
    throw FirmwareError(fmt::format("{}:{}: {}", file_, line_, sentence));
  }

  void read_record(std::string_view line) {
    if (ended_) refuse("there is more after the end record; two files may have been joined");
    if (line.front() != ':') refuse("a record must begin with ':'; is this an Intel HEX file (avr-objcopy -O ihex)?");
    line.remove_prefix(1);
    std::vector<std::uint8_t> record;
    for (std::size_t i = 0; i < line.size(); i += 2) {
      const int high = digit(line[i]), low = i + 1 < line.size() ? digit(line[i + 1]) : -1;
      if (high < 0 || low < 0) refuse(fmt::format("column {}: two hexadecimal digits are missing here", i + 2));
      record.push_back(static_cast<std::uint8_t>(high << 4 | low));
    }
    if (record.size() < 5)
      refuse(fmt::format("the record has {}, but needs at least 5", counted(record.size(), "byte")));
    if (record.size() != record[0] + std::size_t{5})
      refuse(fmt::format("the record announces {} but holds {}", counted(record[0], "data byte"), record.size() - 5));
    std::uint8_t sum = 0;
    for (const std::uint8_t byte : record) sum = static_cast<std::uint8_t>(sum + byte);
    if (sum != 0)
      refuse(fmt::format("the checksum is {:02X} but should be {:02X}; the file is damaged, build or copy it again",
                         record.back(), static_cast<std::uint8_t>(record.back() - sum)));
    const auto address = static_cast<std::uint32_t>(record[1] << 8 | record[2]);
    take_record(record[3], address, std::span<const std::uint8_t>(record).subspan(4, record[0]));
  }

  void take_record(std::uint8_t type, std::uint32_t address, std::span<const std::uint8_t> data) {
    const auto need = [&](std::size_t count) {
      if (data.size() != count)
        refuse(fmt::format("a record of type {:02X} has {} data bytes, not {}", type, count, data.size()));
    };
    switch (type) {
      case 0:
        return put(address, data);
      case 1:
        need(0);
        ended_ = true;
        return;
      case 2:
        need(2);
        base_ = static_cast<std::uint32_t>(data[0] << 8 | data[1]) << 4;
        segmented_ = true;
        return;
      case 4:
        need(2);
        base_ = static_cast<std::uint32_t>(data[0] << 8 | data[1]) << 16;
        segmented_ = false;
        return;
      case 3:
      case 5:
        return need(4);
      default:
        refuse(fmt::format("record type {:02X} is unknown; types are 00 to 05", type));
    }
  }

  void put(std::uint32_t address, std::span<const std::uint8_t> data) {
    for (std::size_t i = 0; i < data.size(); ++i) {
      // within a segment addresses wrap after 64 KiB, beyond it they go on
      const auto offset = static_cast<std::uint32_t>(i);
      const std::uint64_t at = std::uint64_t{base_} + (segmented_ ? (address + offset) & 0xFFFF : address + offset);
      if (at >= max_program_bytes)
        refuse(fmt::format(
            "the program reaches address 0x{:X}, but a robot's memory ends at 0x{:X} ({} bytes); it is too large or "
            "was linked for another address",
            at, max_program_bytes - 1, max_program_bytes));
      const auto place = static_cast<std::size_t>(at);
      if (is_set_[place])
        refuse(fmt::format("address 0x{:X} is set a second time; two programs may have been joined", at));
      is_set_[place] = true;
      bytes_[place] = data[i];
      size_ = std::max(size_, place + 1);
    }
  }

  std::string file_;
  std::size_t line_ = 0;
  std::vector<std::uint8_t> bytes_;
  std::vector<bool> is_set_;
  std::size_t size_ = 0;
  std::uint32_t base_ = 0;
  bool segmented_ = false;
  bool ended_ = false;
};

}  // namespace

Firmware::Firmware(std::vector<std::uint8_t> bytes)
    : size_bytes_(bytes.size()),
      pages_(std::min(max_pages, static_cast<int>(bytes.size() / page_bytes) + 1)),
      bytes_(std::move(bytes)) {
  bytes_.resize(static_cast<std::size_t>(pages_) * page_bytes);
}

std::span<const std::uint8_t, page_bytes> Firmware::page(int page) const {
  return std::span(bytes_).subspan(static_cast<std::size_t>(page) * page_bytes).first<page_bytes>();
}

Firmware parse_intel_hex(std::string_view text, std::string_view file) {
  return Reader(file).read(text);
}

Firmware read_intel_hex(const std::filesystem::path& file) {
  const auto refuse = [&](std::string_view why) { throw FirmwareError(fmt::format("{}: {}", file.string(), why)); };
  if (std::error_code ignored; std::filesystem::is_directory(file, ignored))
    refuse("is a folder, not an Intel HEX file");
  std::ifstream in(file, std::ios::binary);
  if (!in) refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
  std::string text(max_file_bytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > max_file_bytes)
    refuse("is larger than any program for a robot (1 MiB of text); is it an Intel HEX file?");
  return parse_intel_hex(text, file.string());
}

}  // namespace arkmesh::hal::kilobot
