// Robot programs as Intel HEX: what is read, and the sentence for each thing that is wrong.
#include "hal/platforms/kilobot/intel_hex.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;

namespace {

const std::string end_record = ":00000001FF\n";

std::string record(int type, int address, const std::vector<int>& data) {
  std::vector<int> bytes{static_cast<int>(data.size()), address >> 8, address & 0xFF, type};
  bytes.insert(bytes.end(), data.begin(), data.end());
  std::string out = ":";
  for (const int byte : bytes) out += fmt::format("{:02X}", byte);
  return out + fmt::format("{:02X}\n", -std::accumulate(bytes.begin(), bytes.end(), 0) & 0xFF);
}

// A program of that many bytes, 16 to a record; byte i is i + 1 modulo 251.
std::string program(int size) {
  std::string out;
  for (int at = 0; at < size; at += 16) {
    std::vector<int> data;
    for (int i = at; i < std::min(at + 16, size); ++i) data.push_back((i + 1) % 251);
    out += record(0, at, data);
  }
  return out + end_record;
}

std::string error(const std::string& text) {
  try {
    parse_intel_hex(text, "robot.hex");
  } catch (const FirmwareError& error) {
    return error.what();
  }
  return "";
}

void check_complaint(const std::string& text, const std::string& begins, const std::string& holds) {
  const std::string said = error(text);
  CAPTURE(said);
  CHECK(said.starts_with(begins));
  CHECK(said.find(holds) != std::string::npos);
}

}  // namespace

TEST_CASE("hex: contents and pages") {
  // Bytes land where their records say, the rest is zero, and pages are counted as kilogui counts them.
  struct Row {
    int size, pages;
  };
  for (const Row row :
       {Row{1, 1}, Row{127, 1}, Row{128, 2}, Row{129, 2}, Row{7054, 56}, Row{28'159, 220}, Row{28'160, 220}}) {
    CAPTURE(row.size);
    const Firmware firmware = parse_intel_hex(program(row.size), "robot.hex");
    CHECK(firmware.pages() == row.pages);
    CHECK(static_cast<int>(firmware.size_bytes()) == row.size);
    for (int i = 0; i < firmware.pages() * 128; ++i)
      REQUIRE(firmware.page(i / 128)[static_cast<std::size_t>(i % 128)] == (i < row.size ? (i + 1) % 251 : 0));
  }
}

TEST_CASE("hex: gaps, order and kinds of records") {
  // Records may come in any order with gaps between; segment and linear bases count, start addresses do not.
  const Firmware firmware = parse_intel_hex(
      record(4, 0, {0, 0}) + record(0, 300, {7}) + "\n" + record(3, 0, {0, 0, 0, 0}) + record(2, 0, {0, 0x10}) +
          record(0, 2, {9}) + record(5, 0, {0, 0, 0, 0}) + record(4, 0, {0, 0}) + record(0, 0, {5}) + end_record,
      "robot.hex");
  CHECK(firmware.size_bytes() == 301);
  CHECK(firmware.pages() == 3);
  CHECK(firmware.page(0)[0] == 5);
  CHECK(firmware.page(2)[2] == 9);
  CHECK(firmware.page(2)[300 - 256] == 7);
  CHECK(firmware.page(1)[0] == 0);
}

TEST_CASE("hex: line ends and letters") {
  // Files of other systems, with carriage returns, blanks behind records and small letters, are read the same.
  const Firmware firmware = parse_intel_hex(":010000000bf4 \r\n:00000001ff\r\n", "robot.hex");
  CHECK(firmware.size_bytes() == 1);
}

TEST_CASE("hex: complaints") {
  // Each thing that is wrong is said in one sentence with file, line and what to do.
  check_complaint("", "robot.hex: ", "empty");
  check_complaint(record(0, 0, {1}), "robot.hex:1: ", "end record");
  check_complaint(end_record, "robot.hex:1: ", "no program");
  check_complaint(
      "\x7f"
      "ELF\n",
      "robot.hex:1: ", "must begin with ':'");
  check_complaint(record(0, 0, {1}) + ":01000G\n", "robot.hex:2: ", "column 6");
  check_complaint(":0100000\n", "robot.hex:1: ", "column 8");
  check_complaint(":000000\n", "robot.hex:1: ", "at least 5");
  check_complaint(":0200000001FD\n", "robot.hex:1: ", "announces 2 data bytes but holds 1");
  check_complaint(":0100000001FF\n", "robot.hex:1: ", "checksum is FF but should be FE");
  check_complaint(record(6, 0, {}), "robot.hex:1: ", "type 06 is unknown");
  check_complaint(record(2, 0, {1}), "robot.hex:1: ", "type 02 has 2 data bytes, not 1");
  check_complaint(record(4, 0, {1, 2, 3}), "robot.hex:1: ", "type 04 has 2");
  check_complaint(record(5, 0, {}), "robot.hex:1: ", "type 05 has 4");
  check_complaint(record(1, 0, {1}), "robot.hex:1: ", "type 01 has 0");
  check_complaint(end_record + end_record, "robot.hex:2: ", "after the end record");
  check_complaint(record(0, 5, {1, 2}) + record(0, 6, {3}) + end_record,
                  "robot.hex:2: ", "address 0x6 is set a second time");
  check_complaint(program(28'161), "robot.hex:1761: ", "0x6E00");
  check_complaint(record(0, 0x7000, {1}) + end_record, "robot.hex:1: ", "28160 bytes");
  check_complaint(record(4, 0, {0xFF, 0xFF}) + record(0, 0xFFFF, {1, 2}), "robot.hex:2: ", "0xFFFFFFFF");
  check_complaint(record(2, 0, {0xFF, 0xFF}) + record(0, 0xFFFF, {1}), "robot.hex:2: ", "too large");
}

TEST_CASE("hex: files") {
  // A file is read as its text; one that is not there, a folder, or a huge one is named.
  const tests::TemporaryDirectory directory;
  const auto file = directory.path() / "robot.hex";
  std::ofstream(file) << program(1000);
  CHECK(read_intel_hex(file).pages() == 8);
  const auto fails = [](const std::filesystem::path& path, const std::string& why) {
    try {
      read_intel_hex(path);
      FAIL("it was read");
    } catch (const FirmwareError& error) {
      const std::string said = error.what();
      CAPTURE(said);
      CHECK(said.starts_with(path.string() + ": "));
      CHECK(said.find(why) != std::string::npos);
    }
  };
  fails(directory.path() / "none.hex", "No such file");
  fails(directory.path(), "folder");
  std::ofstream(directory.path() / "huge.hex") << std::string((1 << 20) + 1, ':');
  fails(directory.path() / "huge.hex", "larger than any program");
}
