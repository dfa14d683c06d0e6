#include "emulator/room_server.hpp"

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

RoomServer::RoomServer(Room& room, RoomRecord& record)
    : room_(room),
      record_(record),
      pictures_(loop_, room.config().listen, room.config().camera_port),
      reader_(room.config().listen, room.config().ohc_port, room.config().ohc_link),
      control_(room.config().listen, room.config().control_port, "the room's commands (room.control_port)") {}

std::string RoomServer::url(std::size_t camera) const {
  const std::string& listen = room_.config().listen;
  const std::string host = listen == "0.0.0.0" || listen == "::"   ? "127.0.0.1"
                           : listen.find(':') == std::string::npos ? listen
                                                                   : "[" + listen + "]";
  return fmt::format("http://{}:{}/{}", host, pictures_.port(), room_.camera(camera).settings().name);
}

std::chrono::steady_clock::time_point RoomServer::step() {
  if (!std::exchange(started_, true)) start_ = std::chrono::steady_clock::now();
  take_bytes();
  control_.serve([this](std::string_view line) { return room_.command(line); });
  if (plugged_ != room_.ohc_plugged()) {
    plugged_ = room_.ohc_plugged();
    reader_.set_plugged(plugged_);
    if (!plugged_) chunks_.clear();
  }
  take_pictures();
  loop_.poll();
  const Moment frame_at = start_ + frame_ * room_.config().frame_period;
  return std::min<Moment>(frame_at, std::chrono::steady_clock::now() + step_every);
}

// The room advances from chunk to chunk, so that each arrives at its own time, and then to now.
void RoomServer::take_bytes() {
  std::deque<LineReader::Chunk> fresh = reader_.take(known_until_);
  std::ranges::move(fresh, std::back_inserter(chunks_));
  while (!chunks_.empty()) {
    LineReader::Chunk& chunk = chunks_.front();
    room_.advance_to(std::max(room_.now(), since_start(chunk.at)));
    const std::size_t fits = std::min(room_.line_free(), chunk.bytes.size());
    room_.write_serial({chunk.bytes.data(), fits});
    chunk.bytes.erase(chunk.bytes.begin(), chunk.bytes.begin() + static_cast<std::ptrdiff_t>(fits));
    if (!chunk.bytes.empty()) break;  // the line is full
    chunks_.pop_front();
  }
  room_.advance_to(std::max(room_.now(), since_start(known_until_)));
}

void RoomServer::take_pictures() {
  const hal::LabTime period = room_.config().frame_period, wall = since_start(std::chrono::steady_clock::now());
  if (frame_ * period > wall) return;
  // the machine is too slow: pictures that nobody could use any more are not taken
  const std::int64_t newest = wall / period;
  if (newest > frame_) counters_.add("room.frames_skipped", static_cast<std::uint64_t>(newest - frame_));
  frame_ = newest;
  record_.add_truth(room_);
  cv::Mat picture;
  std::vector<std::uint8_t> jpeg;
  for (std::size_t k = 0; k < room_.cameras(); ++k) {
    const std::string& name = room_.camera(k).settings().name;
    if (room_.is_gone(k)) {
      pictures_.close(name);
      record_.add_picture(k, {});
      continue;
    }
    const bool shown = pictures_.watchers(name) > 0 || frame_ % unwatched_every == 0;
    if (!shown && !record_.wants_pictures()) continue;
    if (!room_.picture(k, picture)) continue;
    if (shown) {
      cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, room_.config().jpeg_quality});
      pictures_.show(name, std::as_bytes(std::span(jpeg)));
    }
    record_.add_picture(k, picture);
  }
  ++frame_;
}

hal::Counters RoomServer::counters() const {
  hal::Counters out = room_.counters();
  for (const hal::Counters* part : {&counters_, &pictures_.counters()})
    for (const auto& [name, total] : part->all()) out.add(name, total);
  return out;
}

}  // namespace arkmesh::emulator
