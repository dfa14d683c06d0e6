// The record of everything that passed between a lab and its testbed's devices, as it came: bytes of the serial line
// with their times, camera pictures, at which of the lab's looks each was used, which look gave which frame of poses,
// what the lab said in words, and facts about the machine. Decides nothing; raw_folder.hpp reads it.
//
//   FOLDER/serial.txt            what was written and heard, and when the port opened and closed
//   FOLDER/looks.txt             looks with their pictures, and the frames of poses that the lab took
//   FOLDER/camera0/000000.jpg    pictures, as delivered (.jpg), else without loss (.png)
//   FOLDER/calibration/0.yaml    each camera's calibration file, as it was
//   FOLDER/log.txt, facts.json
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"
#include "hal/time/wall_time.hpp"
#include "hal/types.hpp"
#include "testbed/kilobot_settings.hpp"
#include "testbed/raw_folder.hpp"
#include "testbed/record_writer.hpp"
#include "tracker/camera/live_camera.hpp"

namespace spdlog::sinks {
class sink;
}

namespace arkmesh::testbed {

// Owned by the devices' decorators (recorded_devices.hpp) together. All calls come from the lab's thread.
class RawRecord {
 public:
  struct Settings {
    RecordWriter::Settings writer;
    std::string lab, arena;  // lab.name, arena.use
    KilobotSettings testbed;
  };
  // Times count from now on `wall`, which outlives this. Writes nothing before begin().
  RawRecord(Settings settings, hal::WallTime& wall);
  ~RawRecord();
  RawRecord(const RawRecord&) = delete;
  RawRecord& operator=(const RawRecord&) = delete;

  // Makes the folder, at the first call. Throws std::runtime_error with one sentence.
  void begin();

  void wrote(std::span<const std::uint8_t> bytes);
  void heard(std::span<const std::uint8_t> bytes);
  // `why`: one sentence, or empty.
  void line_is(hal::kilobot::ByteStream::State state, const std::string& why);
  void picture(std::size_t camera, const cv::Mat& bgr, tracker::Arrival arrival);
  // A look at the pictures since the last one; `now` is what the monitor was told.
  void looked(hal::LabTime now);
  // The lab has taken that frame of poses, which the last look gave.
  void frame(std::uint32_t number, hal::LabTime stamp);
  hal::Counters counters() const { return writer_.counters(); }

 private:
  std::int64_t time_us() const;
  void serial(const std::string& text);
  void say_rate();
  void write_facts(bool ended);

  const Settings settings_;
  hal::WallTime& wall_;
  const hal::TimePoint begun_;
  std::int64_t began_utc_s_ = 0;  // seconds since 1970
  RecordWriter writer_;
  bool writes_ = false, said_rate_ = false;
  std::string error_;  // as last said
  struct Eye {
    std::string look = "-";  // of looks.txt: what the next look uses
    std::uint64_t pictures = 0;
    cv::Size size;
  };
  std::vector<Eye> eyes_;
  std::optional<std::int64_t> asked_us_;      // when the next look's first picture was asked for
  std::shared_ptr<spdlog::sinks::sink> log_;  // shared with the logger
};

// What arena.kilobot.record asks for; null when it asks for nothing. `real_time`: the testbed does not wait for the
// disk. Throws ConfigError when the folder holds something.
std::shared_ptr<RawRecord> make_record(const hal::Section& kilobot, const KilobotSettings& settings,
                                       const std::string& lab, const std::string& arena, bool real_time,
                                       hal::WallTime& wall = hal::machine_time());

}  // namespace arkmesh::testbed
