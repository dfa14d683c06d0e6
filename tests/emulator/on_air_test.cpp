// What reaches robots: the driver's packets through a serial line's pace into an overhead controller that behaves, byte
// by byte, as the published firmware was measured to.
#include <doctest/doctest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "emulator/ohc_device.hpp"
#include "hal/platforms/kilobot/firmware_upload.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "hal/platforms/kilobot/overhead_controller.hpp"
#include "hal/random.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using namespace std::chrono_literals;
using emulator::OhcDevice;
using sim_ode::Transmission;

namespace {

constexpr std::int64_t byte_twelfths_us = 3125;  // ten bits at 38400 baud

// The device with the line in front of it; time is microseconds since the beginning.
struct Air {
  explicit Air(std::int64_t slower_percent = 0) : byte_twelfths(byte_twelfths_us * (100 + slower_percent) / 100) {}
  std::int64_t byte_twelfths;
  std::int64_t now_us = 0;
  std::int64_t line_free_twelfths = 0;
  std::deque<std::pair<std::int64_t, std::uint8_t>> coming;  // when its stop bit comes
  OhcDevice device;
  std::vector<Transmission> heard;
  double spoils = 0;  // that share of the bytes
  hal::RandomStream chance{1, "air"};

  void put(std::uint8_t byte) {
    if (spoils > 0 && chance.uniform() < spoils) byte ^= 4;
    line_free_twelfths = std::max(line_free_twelfths, now_us * 12) + byte_twelfths;
    coming.emplace_back(line_free_twelfths / 12, byte);
  }
  void run_to(std::int64_t us) {
    for (; !coming.empty() && coming.front().first <= us; coming.pop_front())
      device.receive(coming.front().second, coming.front().first);
    device.sent_until(us, heard);
    now_us = us;
  }
};

class AirStream final : public ByteStream {
 public:
  explicit AirStream(std::shared_ptr<Air> air) : air_(std::move(air)) {}
  void open() override {}
  State check() override { return State::open; }
  std::size_t write(std::span<const std::uint8_t> bytes) override {
    for (const std::uint8_t byte : bytes) air_->put(byte);
    return bytes.size();
  }
  std::size_t waiting_bytes() override { return air_->coming.size(); }
  const std::string& error() const override { return error_; }

 private:
  std::shared_ptr<Air> air_;  // shared with the test
  std::string error_;
};

struct AirBench {
  AirBench(int robots, const OverheadSettings& settings, std::int64_t slower_percent = 0)
      : air(std::make_shared<Air>(slower_percent)), controller(ids(info, robots), line, settings, counters) {}
  static hal::ArenaInfo& ids(hal::ArenaInfo& info, int robots) {
    for (int i = 0; i < robots; ++i) info.robots.push_back(static_cast<hal::RobotId>(i));
    return info;
  }
  template <class Each>
  void run(std::chrono::milliseconds time, Each each_ms) {
    for (const TimePoint end = now + time; now < end; now += 1ms) {
      air->run_to(std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch()).count());
      each_ms();
      controller.poll(now);
    }
  }
  std::shared_ptr<Air> air;
  hal::Counters counters;
  hal::ArenaInfo info{hal::kilobot::kind_of(hal::kilobot::ark_layout, hal::WholeMessages::to_nobody)};
  PacketPort line{std::make_unique<AirStream>(air), counters};
  OverheadController controller;
  TimePoint now{};
};

}  // namespace

TEST_CASE("on air: composites") {
  // At the usual spacing every composite reaches the air clean at least once, also when bytes come 10 % apart; sent
  // once, exactly once.
  struct Row {
    OverheadSettings settings;
    std::int64_t slower_percent;
    std::size_t least, most;
  };
  for (const Row& row : {Row{{}, 0, 1, 3}, Row{{}, 10, 1, 3}, Row{{.spacing = 60ms}, 0, 2, 4},
                         Row{{.spacing = 42ms, .once = true}, 0, 1, 1}}) {
    CAPTURE(row.settings.spacing.count());
    CAPTURE(row.slower_percent);
    AirBench bench(3, row.settings, row.slower_percent);
    bench.run(2600ms, [] {});
    bench.air->heard.clear();
    // each composite is another one: its blocks bear its number
    std::uint16_t number = 0;
    bench.run(30s, [&] {
      if (bench.controller.airtime().waiting > 0) return;
      ++number;
      std::vector<hal::ToRobot> messages;
      for (hal::RobotId robot = 0; robot < 3; ++robot)
        messages.push_back(
            {robot, 0, static_cast<std::uint8_t>(number >> 8), static_cast<std::uint16_t>(number & 255)});
      bench.controller.offer(messages);
    });
    std::map<int, std::size_t> copies;
    for (const Transmission& sent : bench.air->heard)
      if (sent.clean && sent.message.type == 0) {
        CHECK(sent.message.crc == message_crc(sent.message));
        ++copies[(sent.message.data[1] >> 2 & 15) << 8 | sent.message.data[2]];
      }
    const int sent = number - 1;  // the last one may be on its way
    CHECK(sent >= 30s / row.settings.spacing - 30);
    for (int k = 2; k < sent; ++k) {
      CAPTURE(k);
      CHECK(copies[k] >= row.least);
      CHECK(copies[k] <= row.most);
    }
    CHECK(bench.air->device.counters()["ohc.packets.unknown"] == 0);
    CHECK(bench.air->device.counters()["ohc.packets_overwritten"] == 0);
  }
}

TEST_CASE("on air: commands, questions and silence") {
  // A fleet command is repeated often enough for all robots, a question goes on, and after the stop the air is free.
  AirBench bench(3, {});
  bench.run(2600ms, [] {});
  bench.air->heard.clear();
  bench.controller.command({hal::FleetCommand::Kind::run});
  bench.run(600ms, [] {});
  const auto clean = [&](std::uint8_t type) {
    return std::ranges::count_if(bench.air->heard,
                                 [&](const Transmission& sent) { return sent.clean && sent.message.type == type; });
  };
  CHECK(clean(type_run) >= 40);
  CHECK_FALSE(bench.air->device.on_air(bench.air->now_us - 20'000, bench.air->now_us));
  bench.controller.ask(Message{{5}, 120, 0});
  bench.run(1000ms, [] {});
  CHECK(clean(120) >= 85);
  bench.controller.ask({});
  bench.run(100ms, [] {});
  bench.air->heard.clear();
  bench.run(2000ms, [] {});
  CHECK(bench.air->heard.empty());
}

TEST_CASE("on air: a line that spoils packets") {
  // What matters goes over the line more than once: on one that spoils every fourth packet commands and questions reach
  // the air all the same, and in the end there is silence. Said once, some of them do not.
  for (const bool again : {true, false}) {
    CAPTURE(again);
    AirBench bench(3, {.broadcast_for = 500ms, .again_after = again ? 100ms : 0ms});
    bench.air->spoils = 0.002;
    bench.run(2600ms, [] {});
    int commands = 0, questions = 0, loud = 0;
    for (std::uint8_t n = 0; n < 20; ++n) {
      bench.air->heard.clear();
      bench.controller.command({.kind = hal::FleetCommand::Kind::broadcast, .type = 99, .data = {n}});
      bench.run(700ms, [] {});
      bench.controller.ask(Message{{n}, 120, 0});
      bench.run(500ms, [] {});
      const auto clean = [&](std::uint8_t type) {
        return std::ranges::any_of(bench.air->heard, [&](const Transmission& sent) {
          return sent.clean && sent.message.type == type && sent.message.data[0] == n;
        });
      };
      commands += clean(99);
      questions += clean(120);
      bench.controller.ask({});
      bench.run(600ms, [] {});
      loud += bench.air->device.on_air(bench.air->now_us - 20'000, bench.air->now_us);
    }
    CHECK((commands == 20) == again);
    CHECK((questions == 20) == again);
    CHECK((loud == 0) == again);
  }
}

TEST_CASE("on air: questions between composites") {
  // Questions and composites that take turns all reach the air clean, also when composites are sent once and close to
  // each other.
  for (const OverheadSettings& settings : {OverheadSettings{}, OverheadSettings{.spacing = 40ms, .once = true}}) {
    CAPTURE(settings.once);
    AirBench bench(3, settings);
    bench.run(2600ms, [] {});
    bench.air->heard.clear();
    bench.controller.ask(Message{{5}, 120, 0});
    std::uint16_t number = 0;
    bench.run(10s, [&] {
      const hal::ToRobot message{1, 0, 1, number};
      if (bench.controller.airtime().waiting == 0) bench.controller.offer({&message, 1}), ++number;
    });
    int questions = 0;
    std::set<int> composites;
    for (const Transmission& sent : bench.air->heard) {
      if (!sent.clean) continue;
      questions += sent.message.type == 120;
      if (sent.message.type == 0) composites.insert((sent.message.data[1] & 3) << 8 | sent.message.data[2]);
    }
    CHECK(composites.size() + 2 >= number);
    CHECK(number >= 85);
    CHECK(questions >= 85);
  }
}

TEST_CASE("on air: upload") {
  // Every page of a round reaches the air whole, at the usual spacing and at the smallest; nothing is lost while the
  // controller is deaf.
  for (const auto spacing : {165ms, 132ms}) {
    std::vector<std::uint8_t> program(5000);
    for (std::size_t i = 0; i < program.size(); ++i) program[i] = static_cast<std::uint8_t>(i * i / 7);
    auto air = std::make_shared<Air>();
    hal::Counters counters;
    PacketPort line(std::make_unique<AirStream>(air), counters);
    PacketSender sender(line, 2500ms, counters);
    FirmwareUpload upload(Firmware(program), 1, {.boot_for = 200ms, .spacing = spacing});
    TimePoint now{};
    for (; !upload.is_finished() || !sender.is_ready(now); now += 1ms) {
      REQUIRE(now < TimePoint{} + 60s);
      air->run_to(std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch()).count());
      upload.poll(sender, now);
    }
    air->run_to(air->now_us + 200'000);
    // page and word offset of each message; 22 to a page
    std::map<int, std::set<int>> words;
    for (const Transmission& sent : air->heard)
      if (sent.clean && sent.message.type == type_boot_page) words[sent.message.data[0]].insert(sent.message.data[1]);
    CAPTURE(spacing.count());
    CHECK(upload.pages() == 40);
    CHECK(words.size() == 40);
    CHECK(air->device.counters()["ohc.bytes_lost.deaf"] == 0);
    for (const auto& [page, offsets] : words) CHECK(offsets.size() == 22);
    CHECK(std::ranges::count_if(air->heard, [](const Transmission& sent) {
            return sent.clean && sent.message.type == type_boot_size;
          }) > 0);
  }
}
