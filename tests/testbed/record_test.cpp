// What is recorded at a testbed's devices: bytes, pictures and troubles, and what a full disk or a slow one leaves out.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "testbed/raw_record.hpp"
#include "testbed/recorded_devices.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
namespace fs = std::filesystem;

namespace {

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// A clock that stands where it is put.
struct FixedTime final : hal::WallTime {
  hal::TimePoint at{};
  hal::TimePoint now() override { return at; }
  void wait_until(hal::TimePoint then) override { at = std::max(at, then); }
};

// The record of a testbed of one camera, without a testbed.
struct LooseRecord {
  explicit LooseRecord(testbed::RecordWriter::Settings writer = {}) {
    testbed::KilobotSettings settings;
    settings.cameras = {{.source = "http://me:secret@camera.lab/video", .calibration = folder.path() / "none.yaml"}};
    tracker::CameraData camera;
    camera.lens.width_px = 64, camera.lens.height_px = 48;
    camera.lens.matrix = {60, 0, 32, 0, 60, 24, 0, 0, 1};
    camera.translation_m = {0, 0, 1};
    settings.calibrations.emplace_back(camera);
    settings.arena.port = "/dev/ttyUSB7";
    writer.folder = folder.path() / "raw";
    record = std::make_shared<testbed::RawRecord>(
        testbed::RawRecord::Settings{std::move(writer), "roark", "kilobot", settings}, time);
  }
  std::string text(const char* file) const { return tests::read_file(folder.path() / "raw" / file); }

  tests::TemporaryDirectory folder;
  FixedTime time;
  std::shared_ptr<testbed::RawRecord> record;
};

// A feed whose pictures come as a camera delivers them.
struct JpegFeed final : tracker::CameraFeed {
  explicit JpegFeed(std::vector<std::uint8_t> jpeg) : bytes(std::move(jpeg)) {}
  cv::Mat newest() override { return cv::imdecode(bytes, cv::IMREAD_COLOR); }
  tracker::Arrival arrival() const override { return {.age = hal::LabTime{1000}, .jpeg = bytes}; }
  std::string error() const override { return {}; }
  hal::Counters counters() const override { return {}; }
  std::vector<std::uint8_t> bytes;
};

// A controller that talks and is pulled out.
struct TalkingStream final : hal::kilobot::ByteStream {
  void open() override { state = State::open; }
  State check() override { return state; }
  std::size_t write(std::span<const std::uint8_t> bytes) override { return std::min<std::size_t>(bytes.size(), 2); }
  std::size_t waiting_bytes() override { return 0; }
  const std::string& error() const override { return why; }
  std::span<const std::uint8_t> heard() const override { return said; }
  State state = State::closed;
  std::string why;
  std::vector<std::uint8_t> said;
};

cv::Mat noise(int width_px, int height_px) {
  cv::Mat out(height_px, width_px, CV_8UC3);
  cv::RNG chance(7);
  chance.fill(out, cv::RNG::UNIFORM, 0, 256);
  return out;
}

}  // namespace

TEST_CASE("record: bytes both ways, and the port's troubles") {
  // Proves what serial.txt holds: what was taken of each write, what came back, when the port opened and closed and
  // why, each with its time.
  LooseRecord loose;
  loose.record->begin();
  auto talking = std::make_unique<TalkingStream>();
  TalkingStream& device = *talking;
  {
    const auto stream = testbed::recorded(std::move(talking), loose.record);
    loose.time.at += std::chrono::milliseconds(1);
    stream->open();
    stream->check();
    device.said = {'h', 'i'};
    stream->check();
    device.said.clear();
    loose.time.at += std::chrono::milliseconds(1);
    const std::vector<std::uint8_t> bytes{0x55, 0xAB, 0xCD};
    CHECK(stream->write(bytes) == 2);
    device.state = hal::kilobot::ByteStream::State::closed;
    device.why = "the cable\nwas unplugged";
    stream->check();
    stream->check();
  }
  loose.time.at += std::chrono::milliseconds(1);
  loose.record.reset();
  CHECK(loose.text("serial.txt") ==
        "# arkmesh serial line 1\n1000 opening /dev/ttyUSB7\n1000 open /dev/ttyUSB7\n1000 heard 6869\n2000 wrote 55ab\n"
        "2000 closed the cable was unplugged\n3000 end\n");
  // What a person could not give away stays out of the facts.
  CHECK(says(loose.text("facts.json"), "http://camera.lab/video"));
  CHECK_FALSE(says(loose.text("facts.json"), "secret"));
}

TEST_CASE("record: pictures as they were delivered") {
  // Proves that a camera's JPEG is kept byte for byte, with the time of its arrival, and that a picture without such
  // bytes comes back without loss.
  LooseRecord loose;
  loose.record->begin();
  const cv::Mat plain = noise(64, 48);
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", plain, jpeg);
  {
    const auto open = testbed::recorded(
        [&jpeg](const tracker::CameraRequest&) { return std::make_unique<JpegFeed>(jpeg); }, loose.record);
    const auto feed = open({"0", 64, 48});
    loose.time.at += std::chrono::milliseconds(4);
    CHECK_FALSE(feed->newest().empty());
  }
  loose.record->looked(hal::LabTime{4000});
  loose.record->picture(0, plain, {});
  loose.record->looked(hal::LabTime{5000});
  loose.record->looked(hal::LabTime{6000});
  loose.record->frame(3, hal::LabTime{300'000});
  loose.record.reset();
  CHECK(loose.text("looks.txt") ==
        "# arkmesh looks 1\nlook 4000 4000 000000.jpg@3000\nlook 5000 4000 000001.png@4000\nlook 6000 4000 -\n"
        "frame 3 300000\n");
  const std::string kept = loose.text("camera0/000000.jpg");
  CHECK(std::ranges::equal(kept, jpeg, [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }));
  const cv::Mat back = cv::imread((loose.folder.path() / "raw/camera0/000001.png").string());
  CHECK(cv::norm(back, plain, cv::NORM_INF) == 0);
}

TEST_CASE("record: a disk that is nearly full ends the pictures only") {
  // Proves that pictures end with one sentence and a count while lines and the run go on, and that pictures which come
  // faster than they are written are left out and counted where nobody can wait.
  LooseRecord loose(
      {.patient = true, .keep_free_bytes = std::numeric_limits<std::uint64_t>::max(), .hold_bytes = 20'000});
  loose.record->begin();
  const auto refused = [&] { return loose.record->counters()["raw.not_recorded.disk_full"]; };
  for (int i = 0; i < 5; ++i) {
    loose.record->picture(0, noise(64, 48), {});
    loose.record->looked(hal::LabTime{i});
  }
  CHECK(tests::eventually(std::chrono::seconds(300), [&] { return refused() == 5; }));
  loose.record->wrote(std::vector<std::uint8_t>{1, 2, 3});
  loose.record.reset();
  CHECK(says(loose.text("serial.txt"), "wrote 010203"));
  CHECK(says(loose.text("log.txt"), "no more pictures are recorded, and the run continues"));
  CHECK_FALSE(fs::exists(loose.folder.path() / "raw/camera0"));

  LooseRecord busy({.hold_bytes = 20'000});  // nothing is written before begin(), so nothing makes room
  for (int i = 0; i < 5; ++i) busy.record->picture(0, noise(64, 48), {});
  CHECK(busy.record->counters()["raw.not_recorded.too_fast"] == 3);
}
