// Logs with their index: what is found is what was recorded, and an index that does not fit is made anew.
#include "recording/log.hpp"

#include <doctest/doctest.h>
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "arkmesh/pose_frame_t.hpp"
#include "hal/layout/message.hpp"
#include "hal/record/event_log.hpp"
#include "hal/record/recorder.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
using arkmesh::tests::read_file;
using arkmesh::tests::TemporaryDirectory;
using recording::Log;
namespace fs = std::filesystem;

namespace {

constexpr std::int64_t start_utime = 1'700'000'000'000'000;

std::vector<std::byte> frame_at(std::int64_t stamp_us) {
  pose_frame_t frame{};
  frame.stamp_us = stamp_us;
  frame.parts = 1;
  std::vector<std::byte> out(static_cast<std::size_t>(frame.getEncodedSize()));
  frame.encode(out.data(), 0, static_cast<int>(out.size()));
  return out;
}

// Frames each 0.1 s, something else each second.
void record(hal::Recorder& recorder, int from, int to) {
  for (int n = from; n < to; ++n) {
    const hal::LabTime stamp{n * 100'000};
    recorder.record(stamp, "poses", frame_at(stamp.count()));
    if (n % 10 == 0) recorder.record(stamp, "roark/status", std::vector<std::byte>(static_cast<std::size_t>(n) % 37));
  }
}

fs::path make_log(const TemporaryDirectory& directory, int frames, bool compress = false) {
  hal::Recorder recorder(directory.path(), start_utime, {.compress = compress});
  record(recorder, 0, frames);
  return directory.path() / (compress ? "log.lcm.zst" : "log.lcm");
}

// Whether everything that the log's own reader finds is found here, with channel, time and bytes.
void check_like_the_log(const Log& log) {
  hal::EventLogReader reader(log.file());
  std::size_t at = 0;
  while (const auto event = reader.next()) {
    REQUIRE(at < log.entries().size());
    const auto& entry = log.entries()[at++];
    CHECK(log.channels()[entry.channel] == event->channel);
    CHECK(entry.t_us == event->utime - start_utime);
    CHECK(std::ranges::equal(log.read(entry), event->bytes));
  }
  CHECK(at == log.entries().size());
}

void flip(const fs::path& file, std::uint64_t place) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(place));
  const char byte = static_cast<char>(stream.get());
  stream.seekp(static_cast<std::streamoff>(place));
  stream.put(static_cast<char>(byte ^ 0x10));
}

}  // namespace

TEST_CASE("a log has the messages that its own reader finds, with an index and without") {
  const TemporaryDirectory directory;
  const fs::path file = make_log(directory, 500);
  const std::string before = read_file(file);
  {
    const Log log(file);
    CHECK_FALSE(log.index_was_there());
    check_like_the_log(log);
  }
  CHECK(fs::exists(directory.path() / "log.index"));
  const Log again(file);
  CHECK(again.index_was_there());
  check_like_the_log(again);
  CHECK(again.length_us() == 49'900'000);
  CHECK(again.start_utime() == start_utime);
  CHECK(read_file(file) == before);
}

TEST_CASE("a compressed log has the messages, and the index, of the plain one") {
  const TemporaryDirectory directory, plain;
  const fs::path file = make_log(directory, 500, true);
  { const Log of_plain(make_log(plain, 500)); }
  for (const bool has_index : {false, true}) {
    const Log log(file);
    CHECK(log.index_was_there() == has_index);
    CHECK(log.entries().size() == 550);
    check_like_the_log(log);
  }
  CHECK(read_file(directory.path() / "log.index") == read_file(plain.path() / "log.index"));
}

TEST_CASE("the newest message at or before a moment is found") {
  const TemporaryDirectory directory;
  const Log log(make_log(directory, 100));
  const auto poses = log.find_channel("poses"), status = log.find_channel("roark/status");
  REQUIRE(poses.has_value());
  REQUIRE(status.has_value());
  CHECK_FALSE(log.find_channel("nothing").has_value());
  const auto time_of = [&](std::size_t channel, std::int64_t t) {
    const auto found = log.newest(channel, t);
    return found ? log.entries()[*found].t_us : -1;
  };
  CHECK(time_of(*poses, 0) == 0);
  CHECK(time_of(*poses, 99'999) == 0);
  CHECK(time_of(*poses, 100'000) == 100'000);
  CHECK(time_of(*status, 1'999'999) == 1'000'000);
  CHECK(time_of(*poses, 1'000'000'000) == 9'900'000);
  CHECK(time_of(*poses, -1) == -1);
}

TEST_CASE("an index that is damaged, cut or of another log is made anew") {
  const TemporaryDirectory directory;
  const fs::path file = make_log(directory, 200), index = directory.path() / "log.index";
  { const Log make_index(file); }
  const std::string good = read_file(index);
  for (std::uint64_t place = 0; place < good.size(); place += 97) {
    flip(index, place);
    const Log log(file);
    CHECK_FALSE(log.index_was_there());
    check_like_the_log(log);
    CHECK(read_file(index) == good);
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}, std::size_t{30}, good.size() - 1}) {
    fs::resize_file(index, size);
    const Log log(file);
    CHECK_FALSE(log.index_was_there());
    check_like_the_log(log);
  }
  const TemporaryDirectory other;
  const fs::path other_file = make_log(other, 20);
  fs::copy_file(index, other.path() / "log.index");
  const Log log(other_file);
  CHECK_FALSE(log.index_was_there());
  check_like_the_log(log);
}

TEST_CASE("an index that lies with a right check sum is made anew") {
  const TemporaryDirectory directory;
  const fs::path file = make_log(directory, 200), index = directory.path() / "log.index";
  { const Log make_index(file); }
  const std::string good = read_file(index);
  const auto lies = [&](std::string text) {
    text.resize(text.size() - 4);
    const auto sum = static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(text.data()), text.size()));
    for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>(sum >> shift);
    std::ofstream(index, std::ios::binary) << text;
    const Log log(file);
    CHECK_FALSE(log.index_was_there());
    check_like_the_log(log);
    CHECK(read_file(index) == good);
  };
  constexpr std::size_t event_bytes = 24, sum_bytes = 4;
  const std::size_t events = good.size() - sum_bytes - 220 * event_bytes;
  std::string fewer = good.substr(0, events + 100 * event_bytes) + "sum ";  // of all that the log holds
  fewer[20] = 100;
  lies(fewer);
  std::string other = good;
  other[other.find("poses")] = 'n';  // another channel
  lies(other);
  for (const std::size_t part : {8U, 16U, 20U}) {  // offset, size, channel
    std::string moved = good;
    moved[events + 110 * event_bytes + part] = static_cast<char>(moved[events + 110 * event_bytes + part] ^ 1);
    lies(moved);
  }
}

TEST_CASE("a log that is cut anywhere is used up to its last whole message") {
  const TemporaryDirectory directory;
  const fs::path file = make_log(directory, 30);
  const std::uint64_t whole = fs::file_size(file);
  { const Log make_index(file); }
  for (std::uint64_t size = whole; size-- > whole - 150;) {
    fs::resize_file(file, size);
    const Log log(file);
    check_like_the_log(log);
    CHECK((log.unread_bytes() > 0 || log.entries().back().offset < size));
  }
  fs::resize_file(file, 0);
  const Log empty(file);
  CHECK(empty.entries().empty());
  CHECK(empty.length_us() == 0);
}

TEST_CASE("a log with damage in the middle is used but for that") {
  const TemporaryDirectory directory;
  const fs::path file = make_log(directory, 100);
  std::uint64_t offset = 0;
  std::size_t whole = 0;
  {
    const Log log(file);
    offset = log.entries()[40].offset;
    whole = log.entries().size();
  }
  fs::remove(directory.path() / "log.index");
  flip(file, offset);
  const Log log(file);
  CHECK(log.entries().size() == whole - 1);
  CHECK(log.unread_bytes() == 0);
  CHECK(log.left_out().find(" in 1 place are") != std::string::npos);
  for (const Log::Entry& entry : log.entries()) CHECK(log.read(entry).size() == entry.bytes);
  // and once more, from its index
  CHECK(Log(file).entries().size() == whole - 1);
  CHECK(Log(file).left_out() == log.left_out());
}

TEST_CASE("what a run that goes on writes is taken, and its index grows") {
  const TemporaryDirectory directory;
  hal::Recorder recorder(directory.path(), start_utime, {});
  record(recorder, 0, 50);
  recorder.flush();
  Log log(directory.path() / "log.lcm");
  check_like_the_log(log);
  CHECK_FALSE(log.refresh());
  record(recorder, 50, 80);
  recorder.flush();
  CHECK(log.refresh());
  check_like_the_log(log);
  const Log later(directory.path() / "log.lcm");
  CHECK(later.index_was_there());
  check_like_the_log(later);
}

TEST_CASE("what is no log is refused in a sentence") {
  const TemporaryDirectory directory;
  CHECK_THROWS_WITH(Log(directory.path() / "none.lcm"), doctest::Contains("there is no file"));
  CHECK_THROWS_WITH(Log(directory.write("log.lcm", "hello, I am a text")), doctest::Contains("is not an LCM log"));
}
