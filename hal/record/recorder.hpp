// Records what passes a lab's private bus as an LCM event log, plus named CSV tables. Event time stamps are start + lab
// time, so that lcm-logplayer plays a run at life speed. Never ends a run: a full disk stops the recording, is said
// once and is counted; the run's result tells it (lab::outcome_of).
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "hal/bus/bus.hpp"
#include "hal/counters.hpp"
#include "hal/time/clock.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

class Recorder {
 public:
  struct Options {
    bool log = true;                           // write the LCM log (tables are always written)
    bool compress = false;                     // ... as log.lcm.zst, a zstd frame of each flush
    std::uint64_t keep_free_bytes = 64 << 20;  // stop recording while the disk has less free than this
    double fast_bytes_per_s = 10e6;            // a log that grows faster is said and counted (GrowthWatch)
    std::chrono::milliseconds flush_each{0};   // of wall time, at least, between two flush_period() that write
  };
  // Writes `directory`/log.lcm (or log.lcm.zst) and `directory`/<table>.csv; makes the directory. Throws
  // std::runtime_error when it cannot. `start_utime`: wall microseconds since 1970 that lab time 0 stands for in the
  // log.
  Recorder(const std::filesystem::path& directory, std::int64_t start_utime, Options options);
  ~Recorder();

  // From now on lab time 0 stands for this moment in the log. Before, labs wait for each other and lab time is 0.
  void start_now();
  // One message at lab time `stamp`.
  void record(LabTime stamp, std::string_view channel, std::span<const std::byte> bytes);
  // One that nobody accepted: the first 1000 of a run, as long as they have 4 MiB together; of further ones the number.
  void record_refused(LabTime stamp, std::string_view channel, std::span<const std::byte> bytes);
  // Whatever passes `bus`, stamped by `clock`, while what it returns lives; all three outlive that. Channels that are
  // `left_out` are recorded by whoever knows what came of them.
  [[nodiscard]] std::unique_ptr<Bus::Subscription> record_all(Bus& bus, const Clock& clock,
                                                              std::function<bool(std::string_view channel)> left_out);
  // One row of table `name`; the first call of a table gives its header row.
  void row(std::string_view name, std::string_view header, std::string_view values);
  // Everything so far reaches the file system.
  void flush();
  // The same at the end of a period, so that a killed process leaves whole periods, when it is time for it.
  void flush_period();
  // Reasons and amounts of what was not recorded.
  const Counters& counters() const { return counters_; }
  // False once something could not be written, and then why.
  bool recording() const;
  const std::string& stopped_because() const;
  const std::filesystem::path& directory() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
  Counters counters_;
};

}  // namespace arkmesh::hal
