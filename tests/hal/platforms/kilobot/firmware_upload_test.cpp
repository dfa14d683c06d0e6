// The order and spacing of an upload, in time that the test moves.
#include "hal/platforms/kilobot/firmware_upload.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "tests/support/kilobot/fake_cable.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

namespace {

struct UploadBench {
  UploadBench(std::vector<std::uint8_t> program, std::optional<int> rounds, FirmwareUpload::Timing timing = {})
      : upload(Firmware(std::move(program)), rounds, timing) {}
  void run(std::chrono::milliseconds time) {
    for (const TimePoint end = now + time; now < end; now += 1ms) {
      cable->now = now;
      upload.poll(sender, now);
    }
  }
  hal::Counters counters;
  std::shared_ptr<FakeCable> cable = std::make_shared<FakeCable>();
  PacketPort line{std::make_unique<FakeStream>(cable), counters};
  PacketSender sender{line, 0us, counters};
  FirmwareUpload upload;
  TimePoint now{};
};

std::vector<std::uint8_t> program(std::size_t size) {
  std::vector<std::uint8_t> out(size);
  for (std::size_t i = 0; i < size; ++i) out[i] = static_cast<std::uint8_t>(i % 83);
  return out;
}

}  // namespace

TEST_CASE("upload: a round") {
  // The call to the boot loaders, then in each round the number of pages and every page in order, at the spacing of the
  // setting.
  UploadBench bench(program(300), 2);
  CHECK(bench.upload.pages() == 3);
  CHECK(bench.upload.round_time() == 4 * 165ms);
  bench.run(10s);
  CHECK(bench.upload.is_finished());
  CHECK(bench.upload.round() == 2);
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() == 2 + 2 * 4);
  CHECK(heard[0].type() == PacketType::stop);
  CHECK(heard[1].message_type() == type_boot);
  CHECK(heard[2].at - heard[1].at == 3s);
  for (std::size_t round = 0; round < 2; ++round)
    for (std::size_t k = 0; k < 4; ++k) {
      const FakeCable::Heard& one = heard[2 + 4 * round + k];
      if (round + k > 0) CHECK(one.at - heard[1 + 4 * round + k].at == 165ms);
      if (k == 0) {
        CHECK(one.type() == PacketType::forward);
        CHECK(one.message_type() == type_boot_size);
        CHECK(one.packet[2] == 3);
      } else {
        CHECK(one.type() == PacketType::boot_page);
        CHECK(one.packet[2] == k - 1);
        for (std::size_t i = 0; i < page_bytes; ++i) {
          const std::size_t at = (k - 1) * page_bytes + i;
          CHECK(one.packet[3 + i] == (at < 300 ? at % 83 : 0));
        }
      }
    }
}

TEST_CASE("upload: no end") {
  // Without a number of rounds it goes on until somebody stops it.
  UploadBench bench(program(128), {});
  bench.run(60s);
  CHECK_FALSE(bench.upload.is_finished());
  CHECK(bench.upload.round() == (60'000 - 40 - 3000) / (3 * 165));
}

TEST_CASE("upload: dangerous pages") {
  // Pages full of header bytes are never misread, and no page begins while the controller is still busy with the one
  // before.
  std::vector<std::uint8_t> bytes(28'160);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = i % 3 == 0 ? 0x55 : static_cast<std::uint8_t>(i % 7);
  UploadBench bench(bytes, 1, {.boot_for = 500ms, .spacing = 132ms});
  CHECK(bench.upload.pages() == 220);
  bench.run(60s);
  REQUIRE(bench.upload.is_finished());
  const auto heard = bench.cable->take();
  CHECK(heard.size() == bench.counters["overhead.packets"]);
  CHECK(bench.counters["overhead.parting_stops"] > 0);
  int page = 0;
  for (std::size_t i = 1; i < heard.size(); ++i) {
    if (heard[i - 1].type() == PacketType::boot_page) CHECK(heard[i].at - heard[i - 1].at >= 132ms);
    if (heard[i].type() == PacketType::boot_page) CHECK(heard[i].packet[2] == page++);
  }
  CHECK(page == 220);
}

TEST_CASE("upload: unplugged on the way") {
  // After an interruption it goes on where it was, and does not call the robots to their boot loaders again.
  UploadBench bench(program(2000), 1);
  bench.run(4s);
  const int page = bench.upload.page();
  CHECK(page > 2);
  bench.cable->plugged = false;
  bench.run(3s);
  CHECK(bench.upload.page() == page);
  bench.cable->plugged = true;
  bench.cable->take();
  bench.run(10s);
  CHECK(bench.upload.is_finished());
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() > 2);
  CHECK(heard[0].type() == PacketType::stop);
  CHECK(heard[1].type() == PacketType::boot_page);
  CHECK(heard[1].packet[2] == page);
  CHECK(std::ranges::none_of(
      heard, [](const auto& one) { return one.message_type() == type_boot && one.type() == PacketType::forward; }));
}
