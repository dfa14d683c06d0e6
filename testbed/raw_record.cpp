#include "testbed/raw_record.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>
#include <sys/utsname.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>
#include <thread>
#include <utility>

#include "hal/config/without_secrets.hpp"
#include "tracker/camera/source.hpp"

namespace arkmesh::testbed {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t pictures_to_judge = 20;  // of each camera: then the rate is known
constexpr double mb = 1e6;
constexpr std::size_t patient_hold_bytes = 16u << 20;  // a lab that waits is so far ahead of its record at most

std::string in_hex(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out;
  out.reserve(2 * bytes.size());
  for (const std::uint8_t byte : bytes) {
    out += digits[byte >> 4];
    out += digits[byte & 15];
  }
  return out;
}

}  // namespace

RawRecord::RawRecord(Settings settings, hal::WallTime& wall)
    : settings_(std::move(settings)),
      wall_(wall),
      begun_(wall.now()),
      began_utc_s_(std::time(nullptr)),
      writer_(settings_.writer),
      eyes_(settings_.testbed.cameras.size()) {
  writer_.line(serial_file, serial_head);
  writer_.line(looks_file, looks_head);
}

RawRecord::~RawRecord() {
  if (!writes_) return;
  serial("end");
  writer_.finish();
  write_facts(true);
  std::erase(spdlog::default_logger_raw()->sinks(), log_);
}

void RawRecord::begin() {
  if (writes_) return;
  writer_.begin();
  writes_ = true;
  const fs::path& folder = settings_.writer.folder;
  try {
    log_ = std::make_shared<spdlog::sinks::basic_file_sink_mt>((folder / "log.txt").string());
    spdlog::default_logger_raw()->sinks().push_back(log_);
  } catch (const spdlog::spdlog_ex& error) {
    spdlog::warn("the record has no log.txt: {}", error.what());
  }
  spdlog::info("everything at the testbed's devices is recorded in {}", folder.string());
  std::error_code error;
  fs::create_directories(folder / "calibration", error);
  for (std::size_t i = 0; i < eyes_.size(); ++i) {
    const CameraSettings& camera = settings_.testbed.cameras[i];
    fs::copy_file(camera.calibration, folder / calibration_file_of(i), error);
    if (error) spdlog::warn("the record lacks {}: {}", camera.calibration.string(), error.message());
  }
  write_facts(false);
}

std::int64_t RawRecord::time_us() const {
  return std::chrono::duration_cast<std::chrono::microseconds>(wall_.now() - begun_).count();
}

void RawRecord::serial(const std::string& text) {
  writer_.line(serial_file, fmt::format("{} {}", time_us(), text));
}

void RawRecord::wrote(std::span<const std::uint8_t> bytes) {
  serial("wrote " + in_hex(bytes));
}

void RawRecord::heard(std::span<const std::uint8_t> bytes) {
  serial("heard " + in_hex(bytes));
}

void RawRecord::line_is(hal::kilobot::ByteStream::State state, const std::string& why) {
  using State = hal::kilobot::ByteStream::State;
  std::string sentence = why;
  std::ranges::replace(sentence, '\n', ' ');
  const std::string port = settings_.testbed.arena.port;
  switch (state) {
    case State::opening:
      return serial("opening " + port);
    case State::open:
      return serial("open " + port);
    case State::closed:
      return serial("closed " + sentence);
  }
}

void RawRecord::picture(std::size_t camera, const cv::Mat& bgr, tracker::Arrival arrival) {
  Eye& eye = eyes_[camera];
  eye.size = bgr.size();
  const std::string file = fmt::format("{:06}.{}", eye.pictures++, arrival.jpeg.empty() ? "png" : "jpg");
  if (!asked_us_) asked_us_ = time_us();
  const std::int64_t at = *asked_us_ - arrival.age.count();
  const bool kept = writer_.picture(camera_folder(camera) + "/" + file, bgr, std::move(arrival.jpeg));
  eye.look = kept ? fmt::format("{}@{}", file, std::max<std::int64_t>(0, at)) : "lost";
}

void RawRecord::looked(hal::LabTime now) {
  // from when its pictures were asked for to when they came is their age then, to the microsecond
  std::string line = fmt::format("look {} {}", now.count(), asked_us_ ? *asked_us_ : time_us());
  asked_us_.reset();
  for (Eye& eye : eyes_) line += " " + std::exchange(eye.look, "-");
  writer_.line(looks_file, line);
  if (std::string error = writer_.error(); error != error_) {
    spdlog::warn("{}", error);
    error_ = std::move(error);
  }
  say_rate();
}

void RawRecord::frame(std::uint32_t number, hal::LabTime stamp) {
  writer_.line(looks_file, fmt::format("frame {} {}", number, stamp.count()));
}

// Measured: how large a picture becomes depends on the camera.
void RawRecord::say_rate() {
  if (said_rate_) return;
  const RecordWriter::Written written = writer_.written();
  if (written.pictures < pictures_to_judge * eyes_.size()) return;
  said_rate_ = true;
  const double per_minute = static_cast<double>(written.bytes) / static_cast<double>(written.pictures) *
                            static_cast<double>(eyes_.size()) * 60e6 /
                            static_cast<double>(settings_.testbed.arena.info.frame_period.count());
  std::error_code error;
  const fs::space_info space = fs::space(settings_.writer.folder, error);
  const double room =
      error
          ? 0
          : std::max(0.0, static_cast<double>(space.available) - static_cast<double>(settings_.writer.keep_free_bytes));
  spdlog::info("the record takes {:.0f} MB a minute; the disk has room for {:.0f} minutes ({:.1f} GB)", per_minute / mb,
               room / per_minute, room / 1e9);
  write_facts(false);
}

void RawRecord::write_facts(bool ended) {
  utsname machine{};
  ::uname(&machine);
  nlohmann::json cameras = nlohmann::json::array();
  for (std::size_t i = 0; i < eyes_.size(); ++i) {
    const CameraSettings& camera = settings_.testbed.cameras[i];
    const tracker::Lens& lens = settings_.testbed.calibrations[i].data().lens;
    cameras.push_back({{"source", hal::without_secrets(camera.source)},
                       {"name", camera.name},
                       {"calibrated_px", {lens.width_px, lens.height_px}},
                       {"delivered_px", {eyes_[i].size.width, eyes_[i].size.height}},
                       {"pictures", eyes_[i].pictures}});
  }
  const RecordWriter::Written written = writer_.written();
  const nlohmann::json facts{
      {"record", 1},
      {"arkmesh", ARKMESH_VERSION},
      {"opencv", CV_VERSION},
      {"compiler", __VERSION__},
      {"kernel", fmt::format("{} {} {}", machine.sysname, machine.release, machine.machine)},
      {"processors", std::thread::hardware_concurrency()},
      {"lab", settings_.lab},
      {"arena", settings_.arena},
      {"robots", settings_.testbed.arena.info.robots.size()},
      {"frame_period_us", settings_.testbed.arena.info.frame_period.count()},
      {"port", settings_.testbed.arena.port},
      {"cameras", cameras},
      {"began", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(began_utc_s_)))},
      {"seconds", static_cast<double>(time_us()) * 1e-6},
      {"ended", ended},
      {"written", {{"pictures", written.pictures}, {"bytes", written.bytes}}},
      {"counters", counters().all()}};
  std::ofstream(settings_.writer.folder / "facts.json")
      << facts.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
}

std::shared_ptr<RawRecord> make_record(const hal::Section& kilobot, const KilobotSettings& settings,
                                       const std::string& lab, const std::string& arena, bool real_time,
                                       hal::WallTime& wall) {
  if (settings.record.empty()) return nullptr;
  std::error_code error;
  if (fs::exists(settings.record, error) && !fs::is_empty(settings.record, error))
    kilobot.refuse("record", "is a folder that is not empty; name another one");
  return std::make_shared<RawRecord>(
      RawRecord::Settings{{.folder = settings.record,
                           .patient = !real_time,
                           .hold_bytes = real_time ? RecordWriter::Settings{}.hold_bytes : patient_hold_bytes},
                          lab,
                          arena,
                          settings},
      wall);
}

}  // namespace arkmesh::testbed
