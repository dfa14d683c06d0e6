// Recording: what comes back, what LCM's own reader says of it, and what a full disk costs.
#include "hal/record/recorder.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <lcm/eventlog.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "hal/record/event_log.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh::hal;
using arkmesh::tests::read_file;
using arkmesh::tests::TemporaryDirectory;

namespace {

struct LogEvent {
  std::int64_t number, utime;
  std::string channel;
  std::vector<std::byte> bytes;
};

std::vector<LogEvent> events_of(const std::filesystem::path& file, bool& truncated) {
  std::vector<LogEvent> out;
  EventLogReader reader(file);
  while (auto event = reader.next())
    out.push_back(
        {event->number, event->utime, std::string(event->channel), {event->bytes.begin(), event->bytes.end()}});
  truncated = reader.truncated();
  return out;
}

std::vector<std::byte> payload(std::size_t size) {
  std::vector<std::byte> out(size);
  for (std::size_t i = 0; i < size; ++i) out[i] = static_cast<std::byte>(i * 7);
  return out;
}

// What spdlog says while this lives.
class Warnings {
 public:
  Warnings() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_st>(text_)));
  }
  ~Warnings() { spdlog::set_default_logger(before_); }
  std::string text() const { return text_.str(); }
  int lines() const {
    const std::string all = text_.str();
    return static_cast<int>(std::count(all.begin(), all.end(), '\n'));
  }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

// Files of this process cannot grow beyond `bytes` while this lives: writes fail as on a full disk, in the middle of a
// record.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &limit) == 0);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

}  // namespace

TEST_CASE("what was recorded comes back, in our reader and in LCM's") {
  // Channels, bytes and time stamps (start + lab time) of empty, small and large events.
  TemporaryDirectory directory;
  const std::int64_t start = 1'700'000'000'000'000;
  const std::vector<std::size_t> sizes{0, 1, 5000, 300'000};
  {
    Recorder recorder(directory.path() / "run/shark", start, {});
    for (std::size_t i = 0; i < sizes.size(); ++i)
      recorder.record(LabTime{100'000 * static_cast<std::int64_t>(i)}, "channel" + std::to_string(i),
                      payload(sizes[i]));
  }
  const auto file = directory.path() / "run/shark/log.lcm";
  bool truncated = true;
  const auto events = events_of(file, truncated);
  CHECK(!truncated);
  REQUIRE(events.size() == sizes.size());
  lcm_eventlog_t* log = lcm_eventlog_create(file.c_str(), "r");
  REQUIRE(log);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    CAPTURE(i);
    CHECK(events[i].number == static_cast<std::int64_t>(i));
    CHECK(events[i].utime == start + 100'000 * static_cast<std::int64_t>(i));
    CHECK(events[i].channel == "channel" + std::to_string(i));
    CHECK(events[i].bytes == payload(sizes[i]));
    lcm_eventlog_event_t* theirs = lcm_eventlog_read_next_event(log);
    REQUIRE(theirs);
    CHECK(theirs->eventnum == events[i].number);
    CHECK(theirs->timestamp == events[i].utime);
    CHECK(std::string(theirs->channel, static_cast<std::size_t>(theirs->channellen)) == events[i].channel);
    CHECK(theirs->datalen == static_cast<int>(sizes[i]));
    CHECK(std::equal(events[i].bytes.begin(), events[i].bytes.end(), static_cast<const std::byte*>(theirs->data)));
    lcm_eventlog_free_event(theirs);
  }
  CHECK(lcm_eventlog_read_next_event(log) == nullptr);
  lcm_eventlog_destroy(log);
}

TEST_CASE("after flush everything so far can be read while recording goes on") {
  // As after a SIGKILL: the files are read while the recorder still lives.
  TemporaryDirectory directory;
  Recorder recorder(directory.path(), 0, {});
  recorder.record(LabTime{1}, "a", payload(10));
  recorder.row("hash", "period,hash", "0,abc");
  recorder.flush();
  recorder.record(LabTime{2}, "b", payload(10));
  recorder.row("hash", "period,hash", "1,def");
  bool truncated = true;
  CHECK(events_of(directory.path() / "log.lcm", truncated).size() == 1);
  CHECK(!truncated);
  CHECK(read_file(directory.path() / "hash.csv") == "period,hash\n0,abc\n");
  recorder.flush();
  CHECK(events_of(directory.path() / "log.lcm", truncated).size() == 2);
  CHECK(read_file(directory.path() / "hash.csv") == "period,hash\n0,abc\n1,def\n");
}

TEST_CASE("without a log the tables are still written") {
  // Batches record no messages; that is no loss and counts nothing.
  TemporaryDirectory directory;
  {
    Recorder recorder(directory.path(), 0, {.log = false});
    recorder.record(LabTime{1}, "a", payload(10));
    recorder.row("t", "x", "1");
  }
  CHECK(!std::filesystem::exists(directory.path() / "log.lcm"));
  CHECK(read_file(directory.path() / "t.csv") == "x\n1\n");
}

TEST_CASE("a failing write stops the recording at the last whole record and nothing else") {
  // The file may grow to 1 MiB, which is inside an event: the log ends with the event before, the rest is counted, the
  // warning comes once, and the calls go on without error.
  TemporaryDirectory directory;
  Warnings warnings;
  const std::size_t event_bytes = 28 + 5 + 3000;
  const std::uint64_t events = 1000, fit = (1 << 20) / event_bytes;
  {
    FileSizeLimit limit(1 << 20);
    Recorder recorder(directory.path(), 0, {});
    for (std::uint64_t i = 0; i < events; ++i) {
      recorder.record(LabTime{static_cast<std::int64_t>(i)}, "poses", payload(3000));
      recorder.row("hash", "period,hash", std::to_string(i));
      if (i % 50 == 0) recorder.flush();
    }
    CHECK(!recorder.recording());
    recorder.flush();
    // events and rows: 1000 + 1000 were offered
    bool truncated = true;
    const auto kept = events_of(directory.path() / "log.lcm", truncated);
    CHECK(!truncated);
    CHECK(kept.size() == fit);
    CHECK(std::filesystem::file_size(directory.path() / "log.lcm") == fit * event_bytes);
    const std::string rows = read_file(directory.path() / "hash.csv");
    CHECK(rows.ends_with("\n"));
    const auto kept_rows = static_cast<std::uint64_t>(std::count(rows.begin(), rows.end(), '\n')) - 1;
    CHECK(recorder.counters()["recorder.not_recorded.disk_full"] == events - kept.size() + events - kept_rows);
  }
  CHECK(warnings.lines() == 1);
  CHECK(warnings.text().find("the run continues without it") != std::string::npos);
}

TEST_CASE("recording stops before the disk is full") {
  // With more to keep free than any disk has, what waits is written and the rest is counted.
  TemporaryDirectory directory;
  Warnings warnings;
  Recorder recorder(directory.path(), 0, {.keep_free_bytes = std::uint64_t{1} << 62});
  recorder.record(LabTime{1}, "a", payload(10));
  CHECK(recorder.recording());
  recorder.flush();
  CHECK(!recorder.recording());
  recorder.record(LabTime{2}, "b", payload(10));
  recorder.row("t", "x", "1");
  CHECK(recorder.counters()["recorder.not_recorded.disk_full"] == 2);
  bool truncated = true;
  CHECK(events_of(directory.path() / "log.lcm", truncated).size() == 1);
  CHECK(warnings.lines() == 1);
}

TEST_CASE("of messages that nobody accepted a sample is recorded, and the number of all others") {
  for (const std::size_t size : {std::size_t{78}, std::size_t{100'000}}) {
    CAPTURE(size);
    TemporaryDirectory directory;
    Recorder recorder(directory.path(), 0, {});
    for (int i = 0; i < 5000; ++i) recorder.record_refused(LabTime{i}, "roark/world", payload(size));
    recorder.record(LabTime{5000}, "roark/world", payload(size));
    recorder.flush();
    bool truncated = true;
    const std::size_t events = events_of(directory.path() / "log.lcm", truncated).size();
    CHECK(events == 1 + std::min<std::size_t>(1000, (4 << 20) / size));
    CHECK(recorder.counters()["recorder.not_recorded.refused"] == 5001 - events);
  }
}

TEST_CASE("a log that grows fast is said once, with the channel that makes it grow, and counted") {
  TemporaryDirectory directory;
  const Warnings warnings;
  Recorder recorder(directory.path(), 0, {.fast_bytes_per_s = 1000});
  const auto seconds = [&](int from, int to, std::size_t size) {
    for (int second = from; second < to; ++second) {
      recorder.record(std::chrono::seconds{second}, "poses", payload(100));
      recorder.record(std::chrono::seconds{second}, "roark/cam", payload(size));
    }
  };
  seconds(0, 21, 700);
  CHECK(warnings.lines() == 0);
  seconds(21, 61, 8000);
  CHECK(warnings.lines() == 1);
  CAPTURE(warnings.text());
  CHECK(warnings.text().find("more than recorder.fast_mb_per_s = 0.001; 98 % of that is on the channel roark/cam") !=
        std::string::npos);
  CHECK(recorder.counters()["recorder.grew_fast"] >= 3);
}

TEST_CASE("a directory that cannot be made is refused in one sentence") {
  // A file stands where the directory should be.
  TemporaryDirectory directory;
  const auto file = directory.write("taken", "");
  CHECK_THROWS_WITH_AS(Recorder(file / "run", 0, {}), doctest::Contains("choose another directory"),
                       std::runtime_error);
}

TEST_CASE("of a cut or damaged log the whole events are read") {
  // Cut at every byte, and with every byte of the second event's header damaged.
  TemporaryDirectory directory;
  {
    Recorder recorder(directory.path(), 0, {});
    for (int i = 0; i < 3; ++i) recorder.record(LabTime{i}, "abc", payload(9));
  }
  const std::string whole = read_file(directory.path() / "log.lcm");
  const std::size_t one = 28 + 3 + 9;
  REQUIRE(whole.size() == 3 * one);
  bool truncated = false;
  for (std::size_t length = 4; length <= whole.size(); ++length) {
    CAPTURE(length);
    const auto events = events_of(directory.write("cut.lcm", whole.substr(0, length)), truncated);
    CHECK(events.size() == length / one);
    CHECK(truncated == (length % one != 0));
  }
  for (std::size_t at : {0, 1, 2, 3, 20, 21, 24}) {
    CAPTURE(at);
    std::string damaged = whole;
    damaged[one + at] = static_cast<char>(damaged[one + at] ^ 0xff);
    CHECK(events_of(directory.write("damaged.lcm", damaged), truncated).size() == 2);
    CHECK(truncated);
  }
}

TEST_CASE("a compressed log holds the bytes of the plain one, and is read up to its last whole flush when it is cut") {
  // The same events into both; cut at every byte, and with each byte of the second flush damaged.
  TemporaryDirectory directory;
  const auto plain = directory.path() / "plain/log.lcm", packed = directory.path() / "packed/log.lcm.zst";
  std::vector<std::size_t> ends{0}, plain_ends{0}, events{0};  // after each flush
  {
    Recorder one(plain.parent_path(), 7, {}), other(packed.parent_path(), 7, {.compress = true});
    for (int i = 0; i < 60; ++i) {
      for (Recorder* recorder : {&one, &other}) recorder->record(LabTime{i}, i % 3 ? "abc" : "poses", payload(100));
      if (i % 20 != 19) continue;
      for (Recorder* recorder : {&one, &other}) recorder->flush();
      ends.push_back(std::filesystem::file_size(packed));
      plain_ends.push_back(std::filesystem::file_size(plain));
      events.push_back(static_cast<std::size_t>(i + 1));
      other.flush();  // of nothing
      CHECK(std::filesystem::file_size(packed) == ends.back());
    }
  }
  CHECK(log_in(packed.parent_path()) == packed);
  CHECK(log_in(plain.parent_path()) == plain);
  const std::string whole = read_file(packed);
  REQUIRE(std::system(("zstd -qd " + packed.string()).c_str()) == 0);
  CHECK(read_file(packed.parent_path() / "log.lcm") == read_file(plain));
  CHECK(log_in(packed.parent_path()) == packed.parent_path() / "log.lcm");
  REQUIRE(ends.back() == whole.size());
  CHECK(whole.size() < read_file(plain).size() / 4);

  bool truncated = false;
  const auto all = events_of(plain, truncated);
  const auto read = [&](const std::string& bytes) { return events_of(directory.write("some.zst", bytes), truncated); };
  for (std::size_t length = 4; length <= whole.size(); ++length) {
    CAPTURE(length);
    const auto flushes =
        static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), length) - ends.begin()) - 1;
    const auto found = read(whole.substr(0, length));
    REQUIRE(found.size() == events[flushes]);
    CHECK(truncated == (length != ends[flushes]));
    for (std::size_t i = 0; i < found.size(); ++i) {
      CHECK(found[i].number == all[i].number);
      CHECK(found[i].channel == all[i].channel);
      CHECK(found[i].bytes == all[i].bytes);
    }
  }
  for (std::size_t at = ends[1]; at < ends[2]; ++at) {
    CAPTURE(at);
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0xff);
    // the frame is lost, or no more than its events, and what lies behind it is there
    CHECK(read(damaged).size() == events[1] + events[3] - events[2]);
    CHECK(truncated);
  }
  // One that grows.
  const auto growing = directory.write("growing.zst", whole.substr(0, ends[1] + 5));
  EventLogReader reader(growing);
  std::size_t passed = 0;
  while (reader.next()) ++passed;
  CHECK(passed == events[1]);
  CHECK(reader.unread_bytes() == 5);
  directory.write("growing.zst", whole);
  reader.look_again();
  while (reader.next()) ++passed;
  CHECK(passed == events[3]);
  CHECK(!reader.truncated());
  CHECK(reader.place() == plain_ends[3]);
}

TEST_CASE("a disk that runs full leaves whole frames of a compressed log") {
  // Bytes that cannot be compressed; the limit falls into a frame, whose events are lost and counted.
  TemporaryDirectory directory;
  std::minstd_rand random(1);
  {
    FileSizeLimit limit(100'000);
    Recorder recorder(directory.path(), 0, {.compress = true});
    for (int i = 0; i < 300; ++i) {
      std::vector<std::byte> noise(1000);
      for (std::byte& each : noise) each = static_cast<std::byte>(random());
      recorder.record(LabTime{i}, "poses", noise);
      if (i % 10 == 9) recorder.flush();
    }
    CHECK(!recorder.recording());
    bool truncated = true;
    CHECK(events_of(directory.path() / "log.lcm.zst", truncated).size() == 90);
    CHECK(!truncated);
    CHECK(recorder.counters()["recorder.not_recorded.disk_full"] == 210);
  }
}

TEST_CASE("a log is read on behind damage, and says how much of it was left out") {
  // A header that claims too much, a length that swallows the next event, a hole, a first event that is gone, in a log
  // of events that are equally long.
  TemporaryDirectory directory;
  {
    Recorder recorder(directory.path() / "good", 0, {});
    for (int i = 0; i < 100; ++i) recorder.record(LabTime{i}, "poses", payload(200));
  }
  const std::string good = arkmesh::tests::read_file(directory.path() / "good" / "log.lcm");
  const std::size_t event = good.size() / 100;
  const auto with = [&](const std::string& text) {
    const auto file = directory.write("damaged", text);
    EventLogReader reader(file);
    std::size_t n = 0;
    while (const auto each = reader.next()) {
      CHECK(each->channel == "poses");
      CHECK(std::ranges::equal(each->bytes, payload(200)));
      ++n;
    }
    return std::pair(n, reader.truncated() ? reader.left_out() : "");
  };
  const auto changed = [&](std::size_t at, const std::string& bytes) {
    std::string text = good;
    return text.replace(at, bytes.size(), bytes);
  };
  CHECK(with(good) == std::pair(std::size_t{100}, std::string()));
  const std::string one = fmt::format("{} bytes in 1 place are", event);
  CHECK(with(changed(40 * event + 24, "\x7f")) == std::pair(std::size_t{99}, one));
  CHECK(with(changed(40 * event + 25, "\x10")) == std::pair(std::size_t{99}, one));  // 1 MB: too long
  CHECK(with(changed(40 * event + 26, "\x02")) == std::pair(std::size_t{99}, one));  // swallows others
  CHECK(with(changed(40 * event, "x")) == std::pair(std::size_t{99}, one));          // its sync word
  CHECK(with(changed(0, "xxxx")) == std::pair(std::size_t{99}, one));                // the first
  CHECK(with(changed(40 * event + 30, std::string(event, '\7'))).first == 98);       // two are hit
  CHECK(with(changed(40 * event, std::string(5 * event, '\0'))).first == 95);
  std::string huge = good;
  huge.insert(40 * event, std::string("\xed\xa1\xda\x01", 4) + std::string(15, '\0') + "\5" +
                              std::string("\0\0\0\4\x7f\xff\xff\xff", 8) + "huge");
  CHECK(with(huge).first == 100);
  const auto [n, words] = with(changed(40 * event, "x").substr(0, 99 * event + 10));
  CHECK(n == 98);
  CHECK(words == fmt::format("{} bytes in 1 place and its last 10 bytes are", event));
}

TEST_CASE("what is no log is refused in one sentence") {
  // Absent, a directory, empty, a text, a device.
  TemporaryDirectory directory;
  const auto error = [](const std::filesystem::path& file) {
    try {
      EventLogReader reader(file);
    } catch (const std::runtime_error& why) {
      return std::string(why.what());
    }
    return std::string();
  };
  const std::string at = directory.path().string();
  CHECK(error(at + "/none") == "there is no file " + at + "/none");
  CHECK(error(at) == at + " is not a file");
  CHECK(error(directory.write("empty", "")).empty());
  CHECK(error(directory.write("text", "hello there")) == at + "/text is not an LCM log");
  CHECK(error(directory.write("short", "\xed\xa1")) == at + "/short is not an LCM log");
  CHECK(error("/dev/zero") == "/dev/zero is not a file");
  // Compressed by others: no log, and in a piece whose size it does not tell.
  const auto packed = [&](const std::string& command) {
    REQUIRE(std::system((command + " > " + at + "/packed").c_str()) == 0);
    return error(at + "/packed");
  };
  CHECK(packed("echo hello | zstd -q --stream-size=6") == at + "/packed is not an LCM log");
  CHECK(packed("echo hello | zstd -q").find("unpack it with `zstd -d " + at + "/packed`") != std::string::npos);
}
