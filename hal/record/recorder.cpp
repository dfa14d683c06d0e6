// The LCM log and the tables are files of whole records; all of them stop together when one of them cannot be written.
#include "hal/record/recorder.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

#include <cassert>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <system_error>

#include "hal/record/event_log.hpp"
#include "hal/record/growth_watch.hpp"
#include "hal/record/record_file.hpp"

namespace arkmesh::hal {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t buffer_bytes = 256 << 10;       // written out when this much waits
constexpr std::uint64_t check_every_bytes = 1 << 20;  // how often the disk's free space is looked at
constexpr std::uint64_t look_at_clock_each = 16;      // events; it costs as much as recording one
constexpr std::uint64_t most_refused = 1000, most_refused_bytes = 4 << 20;

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span<const char>(text.data(), text.size()));
}

}  // namespace

struct Recorder::State {
  fs::path directory;
  std::int64_t start_utime;
  Options options;
  Counters& counters;
  bool recording = true;
  std::uint64_t events = 0;
  std::uint64_t refused = 0, refused_bytes = 0;  // recorded of what nobody accepted
  GrowthWatch growth_{options.fast_bytes_per_s};
  std::uint64_t unchecked_bytes = check_every_bytes;  // written since free space was last looked at
  std::unique_ptr<RecordFile> log;
  std::map<std::string, std::unique_ptr<RecordFile>, std::less<>> tables;

  template <class Each>
  void for_each_file(Each each) {
    if (log) each(*log);
    for (auto& [name, file] : tables) each(*file);
  }

  void lose(std::uint64_t records, int error) {
    const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
    counters.add(full ? "recorder.not_recorded.disk_full" : "recorder.not_recorded.write_failed", records);
  }

  // Keeps what has been recorded so far and records no more.
  void stop(const std::string& why, int error) {
    if (!recording) return;
    recording = false;
    stopped_by = error;
    stopped_because = why;
    spdlog::warn("recording in {} stopped: {}; the run continues without it", directory.string(), why);
    for_each_file([&](RecordFile& file) { lose(file.write_out().lost, error); });
  }

  void write_out(RecordFile& file) {
    if (!recording || file.waiting_bytes() == 0) return;
    unchecked_bytes += file.waiting_bytes();
    if (unchecked_bytes >= check_every_bytes) {
      unchecked_bytes = 0;
      struct statvfs disk {};
      if (statvfs(directory.c_str(), &disk) == 0) {
        const std::uint64_t free_bytes = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
        if (free_bytes < options.keep_free_bytes) {
          stop(fmt::format("the disk has {} MB left, less than the {} MB to keep free", free_bytes / 1'000'000,
                           options.keep_free_bytes / 1'000'000),
               ENOSPC);
          return;
        }
      }
    }
    if (const auto [error, lost] = file.write_out(); error != 0) {
      lose(lost, error);
      stop(std::strerror(error), error);
    }
  }

  // True when the record may be appended; else it is counted.
  bool may_record() {
    if (!recording) lose(1, stopped_by);
    return recording;
  }

  void end_record(RecordFile& file) {
    file.end_record();
    if (file.waiting_bytes() >= buffer_bytes) write_out(file);
  }

  void watch_growth(LabTime stamp, std::string_view channel, std::size_t bytes) {
    if (events % look_at_clock_each == 1) wall = std::chrono::steady_clock::now();
    const auto growth =
        growth_.add(stamp, std::chrono::duration_cast<LabTime>(wall.time_since_epoch()), channel, bytes);
    if (!growth) return;
    if (counters["recorder.grew_fast"] == 0)
      spdlog::warn(
          "recording in {} grows by {:.0f} MB/s, more than recorder.fast_mb_per_s = {:g}; {:.0f} % of that is on the "
          "channel {}",
          directory.string(), growth->bytes_per_s / 1e6, options.fast_bytes_per_s / 1e6, 100 * growth->share,
          growth->channel);
    counters.add("recorder.grew_fast");
  }

  int stopped_by = 0;  // errno
  std::string stopped_because;
  std::chrono::steady_clock::time_point wall{};     // of one of the newest events
  std::chrono::steady_clock::time_point flushed{};  // by flush_period()
};

Recorder::Recorder(const fs::path& directory, std::int64_t start_utime, Options options)
    : state_(new State{directory, start_utime, options, counters_}) {
  std::error_code error;
  fs::create_directories(directory, error);
  try {
    if (error) throw std::system_error(error);
    if (options.log)
      state_->log =
          std::make_unique<RecordFile>(directory / (options.compress ? packed_log_name : log_name), options.compress);
  } catch (const std::system_error& cause) {
    throw std::runtime_error(
        fmt::format("cannot record in {}: {}; choose another directory", directory.string(), cause.code().message()));
  }
}

Recorder::~Recorder() {
  flush();
}

void Recorder::start_now() {
  using namespace std::chrono;
  state_->start_utime = duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
}

void Recorder::record(LabTime stamp, std::string_view channel, std::span<const std::byte> bytes) {
  if (!state_->log || !state_->may_record()) return;
  const EventHeader::Bytes header =
      EventHeader{static_cast<std::int64_t>(state_->events++), state_->start_utime + stamp.count(),
                  static_cast<std::uint32_t>(channel.size()), static_cast<std::uint32_t>(bytes.size())}
          .encoded();
  state_->log->append(header);
  state_->log->append(bytes_of(channel));
  state_->log->append(bytes);
  state_->end_record(*state_->log);
  state_->watch_growth(stamp, channel, header.size() + channel.size() + bytes.size());
}

void Recorder::record_refused(LabTime stamp, std::string_view channel, std::span<const std::byte> bytes) {
  if (!state_->log) return;
  if (state_->refused == most_refused || state_->refused_bytes + bytes.size() > most_refused_bytes)
    return counters_.add("recorder.not_recorded.refused");
  ++state_->refused;
  state_->refused_bytes += bytes.size();
  record(stamp, channel, bytes);
}

std::unique_ptr<Bus::Subscription> Recorder::record_all(Bus& bus, const Clock& clock,
                                                        std::function<bool(std::string_view channel)> left_out) {
  return bus.subscribe(".*", [this, &clock, left_out](std::string_view channel, std::span<const std::byte> bytes) {
    if (!left_out(channel)) record(clock.now(), channel, bytes);
  });
}

void Recorder::row(std::string_view name, std::string_view header, std::string_view values) {
  assert(name.find('/') == std::string_view::npos && "a table is a file in the run's directory");
  if (!state_->may_record()) return;
  auto table = state_->tables.find(name);
  if (table == state_->tables.end()) {
    try {
      auto file = std::make_unique<RecordFile>(state_->directory / fmt::format("{}.csv", name));
      table = state_->tables.emplace(name, std::move(file)).first;
    } catch (const std::system_error& error) {
      state_->stop(error.what(), error.code().value());
      state_->lose(1, error.code().value());
      return;
    }
    table->second->append(bytes_of(header));
    table->second->append(bytes_of("\n"));
  }
  table->second->append(bytes_of(values));
  table->second->append(bytes_of("\n"));
  state_->end_record(*table->second);
}

void Recorder::flush() {
  if (struct stat there{}; state_->recording && stat(state_->directory.c_str(), &there) != 0)
    state_->stop("the folder was removed", ENOENT);
  state_->for_each_file([&](RecordFile& file) { state_->write_out(file); });
}

void Recorder::flush_period() {
  const auto now = std::chrono::steady_clock::now();
  if (now - state_->flushed < state_->options.flush_each) return;
  state_->flushed = now;
  flush();
}

bool Recorder::recording() const {
  return state_->recording;
}

const std::string& Recorder::stopped_because() const {
  return state_->stopped_because;
}

const fs::path& Recorder::directory() const {
  return state_->directory;
}

}  // namespace arkmesh::hal
