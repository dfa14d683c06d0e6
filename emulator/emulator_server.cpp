#include "emulator/emulator_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <utility>

namespace arkmesh::emulator {
namespace {

using namespace std::chrono_literals;

constexpr auto step_every = 2ms;
// For those who come next, while nobody watches.
constexpr std::int64_t unwatched_every = 5;

}  // namespace

EmulatorServer::EmulatorServer(Emulator& emulator, EmulatorRecord& record)
    : emulator_(emulator),
      record_(record),
      pictures_(emulator.config().listen, emulator.config().camera_port),
      reader_(emulator.config().listen, emulator.config().ohc_port, emulator.config().ohc_link),
      control_(emulator.config().listen, emulator.config().control_port,
               "the emulator's commands (emulator.control_port)") {}

std::string EmulatorServer::url(std::size_t camera) const {
  const std::string& listen = emulator_.config().listen;
  const std::string host = listen == "0.0.0.0" || listen == "::"   ? "127.0.0.1"
                           : listen.find(':') == std::string::npos ? listen
                                                                   : "[" + listen + "]";
  return fmt::format("http://{}:{}/{}", host, pictures_.port(), emulator_.camera(camera).settings().name);
}

std::chrono::steady_clock::time_point EmulatorServer::step() {
  if (!std::exchange(started_, true)) start_ = std::chrono::steady_clock::now();
  take_bytes();
  control_.serve([this](std::string_view line) { return emulator_.command(line); });
  if (plugged_ != emulator_.ohc_plugged()) {
    plugged_ = emulator_.ohc_plugged();
    reader_.set_plugged(plugged_);
    if (!plugged_) chunks_.clear();
  }
  take_pictures();
  pictures_.serve();
  const TimePoint frame_at = start_ + frame_ * emulator_.config().frame_period;
  return std::min<TimePoint>(frame_at, std::chrono::steady_clock::now() + step_every);
}

// The emulator advances from chunk to chunk, so that each arrives at its own time, and then to now.
void EmulatorServer::take_bytes() {
  std::deque<SerialReader::Chunk> fresh = reader_.take(known_until_);
  std::ranges::move(fresh, std::back_inserter(chunks_));
  while (!chunks_.empty()) {
    SerialReader::Chunk& chunk = chunks_.front();
    emulator_.advance_to(std::max(emulator_.now(), since_start(chunk.at)));
    const std::size_t fits = std::min(emulator_.serial_free(), chunk.bytes.size());
    emulator_.write_serial({chunk.bytes.data(), fits});
    chunk.bytes.erase(chunk.bytes.begin(), chunk.bytes.begin() + static_cast<std::ptrdiff_t>(fits));
    if (!chunk.bytes.empty()) break;  // the line is full
    chunks_.pop_front();
  }
  emulator_.advance_to(std::max(emulator_.now(), since_start(known_until_)));
}

void EmulatorServer::take_pictures() {
  const hal::LabTime period = emulator_.config().frame_period, wall = since_start(std::chrono::steady_clock::now());
  if (frame_ * period > wall) return;
  // the machine is too slow: pictures that nobody could use any more are not taken
  const std::int64_t newest = wall / period;
  if (newest > frame_) counters_.add("emulator.frames_skipped", static_cast<std::uint64_t>(newest - frame_));
  frame_ = newest;
  record_.add_truth(emulator_);
  cv::Mat picture;
  std::vector<std::uint8_t> jpeg;
  for (std::size_t k = 0; k < emulator_.cameras(); ++k) {
    const std::string& name = emulator_.camera(k).settings().name;
    if (emulator_.is_gone(k)) {
      pictures_.close(name);
      record_.add_picture(k, {});
      continue;
    }
    const bool shown = pictures_.watchers(name) > 0 || frame_ % unwatched_every == 0;
    if (!shown && !record_.wants_pictures()) continue;
    if (!emulator_.picture(k, picture)) continue;
    if (shown) {
      cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, emulator_.config().jpeg_quality});
      pictures_.show(name, std::as_bytes(std::span(jpeg)));
    }
    record_.add_picture(k, picture);
  }
  ++frame_;
}

hal::Counters EmulatorServer::counters() const {
  hal::Counters out = emulator_.counters();
  for (const hal::Counters* part : {&counters_, &pictures_.counters()})
    for (const auto& [name, total] : part->all()) out.add(name, total);
  return out;
}

}  // namespace arkmesh::emulator
