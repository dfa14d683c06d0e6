// Replaying logs, good and bad. What every arena promises: tests/conformance.
#include "hal/arenas/log_arena.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "hal/arenas/messages.hpp"
#include "hal/record/recorder.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
using namespace arkmesh::hal;
using arkmesh::tests::TemporaryDirectory;

namespace {

template <class Message>
void record(Recorder& recorder, LabTime stamp, const std::string& channel, const Message& message) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  recorder.record(stamp, channel, bytes);
}

// Frame n of the test log: robots 2, 4, 6, ... somewhere that depends on n.
PoseFrame frame_of(std::uint32_t number, int robots = 3, LabTime period = LabTime{55'000}) {
  PoseFrame out;
  out.number = number;
  out.stamp = number * period;
  for (int i = 1; i <= robots; ++i)
    out.robots.push_back({static_cast<RobotId>(2 * i), {0.01 * i, 0.001 * number, 0.1}, Led::red, 0.75F, LabTime{9}});
  return out;
}

ArenaInfo info_of() {
  ArenaInfo out;
  out.name = "recorded";
  out.width_m = 0.5;
  out.height_m = 0.25;
  out.max_robot = 100;
  out.kinds = 8;
  out.values = 64;
  return out;
}

// Records by `fill` and returns the log.
std::filesystem::path make_log(const TemporaryDirectory& directory, const std::function<void(Recorder&)>& fill) {
  Recorder recorder(directory.path(), 1'700'000'000'000'000, {});
  fill(recorder);
  return directory.path() / "log.lcm";
}

void record_frames(Recorder& recorder, std::uint32_t from, std::uint32_t to, int robots = 3) {
  for (std::uint32_t n = from; n < to; ++n)
    for (const auto& part : to_messages(frame_of(n, robots))) record(recorder, frame_of(n).stamp, channel::poses, part);
}

std::unique_ptr<Arena> replay(const std::filesystem::path& log, LabTime length, const std::string& more = {},
                              const RobotKind& robot = {}) {
  const Config config =
      Config::from_text("[arena]\n" + more + "\n[arena.replay]\nlog = \"" + log.string() + "\"\n", "a.toml");
  auto out = make_log_arena(config.root().section("arena"), "lab", robot, length);
  config.refuse_unknown();
  return out;
}

std::string replay_error(const std::filesystem::path& log, LabTime length = LabTime{0}) {
  try {
    replay(log, length);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

bool same(const PoseFrame& a, const PoseFrame& b) {
  if (a.number != b.number || a.stamp != b.stamp || a.robots.size() != b.robots.size()) return false;
  for (std::size_t i = 0; i < a.robots.size(); ++i) {
    const Observation &p = a.robots[i], &q = b.robots[i];
    if (p.robot != q.robot || p.pose.x_m != q.pose.x_m || p.pose.y_m != q.pose.y_m ||
        p.pose.heading_rad != q.pose.heading_rad || p.led != q.led || p.confidence != q.confidence || p.age != q.age)
      return false;
  }
  return true;
}

}  // namespace

TEST_CASE("a log's poses come back with its robots, size and frame period") {
  // What the keys of other arenas say does not matter, and they stay allowed.
  TemporaryDirectory directory;
  const auto log = make_log(directory, [](Recorder& recorder) {
    record(recorder, LabTime{0}, channel::arena, to_message(info_of()));
    record_frames(recorder, 0, 41);
  });
  const auto arena = replay(log, LabTime{40 * 55'000}, "width_m = 3\nrobots = 9\nframe_period_s = 0.5\npace = 1");
  CHECK(arena->info().name == "lab");
  CHECK(arena->info().platform == "replay");
  CHECK(arena->info().can_wait);
  CHECK(arena->info().width_m == 0.5);
  CHECK(arena->info().height_m == 0.25);
  CHECK(arena->info().frame_period == LabTime{55'000});
  CHECK(arena->info().robots == std::vector<RobotId>{2, 4, 6});
  CHECK(arena->info().max_robot == 100);
  CHECK(arena->info().kinds == 8);
  CHECK(arena->info().values == 64);
  for (std::uint32_t n = 0; n <= 40; ++n) {
    CAPTURE(n);
    arena->advance_to(n * LabTime{55'000});
    const auto frame = arena->poses().latest();
    REQUIRE(frame);
    CHECK(same(*frame, frame_of(n)));
    CHECK(!arena->poses().latest());
  }
  CHECK(arena->counters().all().empty());
}

TEST_CASE("robots are as large as the log tells, and words lie as it tells") {
  TemporaryDirectory directory;
  const auto log = make_log(directory, [&](Recorder& recorder) {
    ArenaInfo info = info_of();
    info.body_radius_m = 0.02;
    info.id_bits = 7;
    info.whole = WholeMessages::to_everyone;
    record(recorder, LabTime{0}, channel::arena, to_message(info));
    record_frames(recorder, 0, 3);
  });
  RobotKind robot;
  robot.body_radius_m = 0.0165;
  const auto arena = replay(log, LabTime{2 * 55'000}, {}, robot);
  CHECK(arena->info().body_radius_m == 0.02);
  CHECK(arena->info().id_bits == 7);
  CHECK(arena->info().whole == WholeMessages::to_everyone);
}

TEST_CASE("size comes from the keys when the log does not tell") {
  // A log of poses alone.
  TemporaryDirectory directory;
  const auto log = make_log(directory, [](Recorder& recorder) { record_frames(recorder, 0, 5); });
  CHECK(replay(log, LabTime{0}, "width_m = 3")->info().width_m == 3);
  CHECK(replay(log, LabTime{0})->info().height_m == 1);
}

TEST_CASE("frames in several parts are put together") {
  // 2500 robots are three messages; other channels between them do not matter.
  TemporaryDirectory directory;
  const auto log = make_log(directory, [](Recorder& recorder) {
    for (std::uint32_t n = 0; n < 3; ++n)
      for (const auto& part : to_messages(frame_of(n, 2500))) {
        record(recorder, LabTime{0}, channel::poses, part);
        recorder.record(LabTime{0}, "noise", {});
      }
  });
  const auto arena = replay(log, LabTime{110'000});
  CHECK(arena->info().robots.size() == 2500);
  arena->advance_to(LabTime{110'000});
  const auto frame = arena->poses().latest();
  REQUIRE(frame);
  CHECK(same(*frame, frame_of(2, 2500)));
  CHECK(arena->counters()["poses.skipped"] == 2);
}

TEST_CASE("frames that are incomplete, repeated or damaged are left out and counted") {
  // Frames 0 and 9 are good; between them one of each kind of bad.
  TemporaryDirectory directory;
  const auto log = make_log(directory, [](Recorder& recorder) {
    const auto one = [&](std::uint32_t number, const std::function<void(pose_frame_t&)>& spoil) {
      pose_frame_t part = to_messages(frame_of(number)).front();
      spoil(part);
      record(recorder, LabTime{0}, channel::poses, part);
    };
    record_frames(recorder, 0, 2);
    const auto large = to_messages(frame_of(2, 2500));
    record(recorder, LabTime{0}, channel::poses, large[0]);  // part 1 is missing
    record(recorder, LabTime{0}, channel::poses, large[2]);
    record(recorder, LabTime{0}, channel::poses, large[0]);  // never ends
    record_frames(recorder, 3, 4);
    record_frames(recorder, 3, 4);  // twice the same
    one(4, [](auto& part) { part.robots[0].x_m = std::numeric_limits<double>::quiet_NaN(); });
    one(4, [](auto& part) { part.robots[0].x_m = 1e300; });
    one(4, [](auto& part) { part.robots[0].robot = 70'000; });
    one(4, [](auto& part) { std::swap(part.robots[0], part.robots[1]); });
    one(4, [](auto& part) { part.robots[0].heading_rad = 4; });
    one(4, [](auto& part) { part.robots[0].led = 9; });
    one(4, [](auto& part) { part.parts = 0; });
    one(4, [](auto& part) { part.stamp_us = -1; });
    recorder.record(LabTime{0}, channel::poses, std::vector<std::byte>(100));
    recorder.record(LabTime{0}, channel::poses, {});
    record_frames(recorder, 9, 10);
  });
  const auto arena = replay(log, 9 * LabTime{55'000});
  std::vector<std::uint32_t> numbers;
  for (int n = 0; n <= 9; ++n) {
    arena->advance_to(n * LabTime{55'000});
    if (const auto frame = arena->poses().latest()) numbers.push_back(frame->number);
  }
  CHECK(numbers == std::vector<std::uint32_t>{0, 1, 3, 9});
  CHECK(arena->counters()["replay.refused.incomplete"] == 2);
  CHECK(arena->counters()["replay.refused.out_of_order"] == 1);
  CHECK(arena->counters()["replay.refused.damaged"] == 10);
}

TEST_CASE("stamps whose product with a frame's number overflows are not even") {
  // Five frame periods of this log are 2^64 us and a little more than one; modulo 2^64 that is a stamp that rises.
  TemporaryDirectory directory;
  const auto log = make_log(directory, [](Recorder& recorder) {
    const auto one = [&](std::uint32_t number, std::int64_t stamp_us) {
      pose_frame_t part = to_messages(frame_of(number)).front();
      part.stamp_us = stamp_us;
      record(recorder, LabTime{0}, channel::poses, part);
    };
    constexpr std::int64_t period_us = 0x4000'0000'0000'0001;
    one(0, 0);
    one(1, period_us);
    one(5, static_cast<std::int64_t>(5 * std::uint64_t{period_us}));  // modulo 2^64, later than frame 1
  });
  CHECK(replay_error(log).ends_with(": the log's frames are not stamped number times frame period"));
}

TEST_CASE("a message that claims more robots than it holds costs no memory") {
  // 2^31-1 robots in 32 bytes; the generated decoder would ask for 100 GB.
  TemporaryDirectory directory;
  const auto log = make_log(directory, [](Recorder& recorder) {
    record_frames(recorder, 0, 2);
    pose_frame_t part = to_messages(frame_of(2)).front();
    std::vector<std::byte> bytes(static_cast<std::size_t>(part.getEncodedSize()));
    part.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    bytes.resize(32);
    for (int value : {0x7f, 0xff}) {
      for (std::size_t i = 28; i < 32; ++i) bytes[i] = static_cast<std::byte>(i == 28 ? value : 0xff);
      recorder.record(LabTime{0}, channel::poses, bytes);
    }
  });
  const auto arena = replay(log, LabTime{55'000});
  arena->advance_to(LabTime{55'000});
  CHECK(arena->counters()["replay.refused.damaged"] == 2);
}

TEST_CASE("a run that the log cannot carry is refused in one sentence") {
  // Too long, no poses, a beginning that is missing, uneven stamps, no log at all.
  TemporaryDirectory directory, more, late, uneven, cut;
  const auto log = make_log(directory, [](Recorder& recorder) { record_frames(recorder, 0, 11); });
  CHECK(replay_error(log, LabTime{550'000}).empty());
  const std::string too_long = replay_error(log, LabTime{550'001});
  CHECK(too_long.starts_with("a.toml:4: arena.replay.log = \""));
  CHECK(too_long.ends_with(
      ": the log ends at 0.55 s, but the run needs 0.550001 s; shorten the run or use a longer log"));
  CHECK(replay_error(make_log(more, [](Recorder& recorder) {
          recorder.record(LabTime{0}, "world", {});
        })).ends_with(": the log holds no poses"));
  CHECK(replay_error(make_log(late, [](Recorder& recorder) { record_frames(recorder, 5, 9); }))
            .ends_with(
                ": the log begins with frame 5 at 0.275 s, not with frame 0; record it from the beginning of a run"));
  CHECK(replay_error(make_log(uneven, [](Recorder& recorder) {
          record_frames(recorder, 0, 2);
          pose_frame_t part = to_messages(frame_of(2)).front();
          part.stamp_us += 1;
          record(recorder, LabTime{0}, channel::poses, part);
        })).ends_with(": the log's frames are not stamped number times frame period"));
  CHECK(replay_error(directory.path() / "none.lcm").find("there is no file") != std::string::npos);
  CHECK(replay_error(directory.write("text.lcm", "not a log")).find("is not an LCM log") != std::string::npos);
  CHECK(replay_error("").ends_with("must not be empty; write one such as \"log.lcm\""));

  // a cut log is good up to its last whole frame
  const std::string whole = arkmesh::tests::read_file(log);
  const auto cut_log = cut.write("cut.lcm", whole.substr(0, whole.size() - 1));
  CHECK(replay_error(cut_log, LabTime{495'000}).empty());
  CHECK(replay_error(cut_log, LabTime{550'000}).find("the log ends at 0.495 s") != std::string::npos);
}

TEST_CASE("a log that shrinks during the run ends it with one sentence") {
  // Somebody overwrites the log after the run began.
  TemporaryDirectory directory;
  const auto log = make_log(directory, [](Recorder& recorder) { record_frames(recorder, 0, 4000); });
  const auto arena = replay(log, 3999 * LabTime{55'000});
  arena->advance_to(LabTime{0});
  std::filesystem::resize_file(log, std::filesystem::file_size(log) / 2);
  CHECK_THROWS_WITH_AS(arena->advance_to(3999 * LabTime{55'000}), doctest::Contains("changed during the replay"),
                       std::runtime_error);
}
