#include "emulator/emulator_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <opencv2/imgcodecs.hpp>
#include <utility>

namespace arkmesh::emulator {
namespace {

using namespace std::chrono_literals;

constexpr auto look_at_full_line_after = 10ms;  // 38 bytes
// For those who come next, while nobody watches.
constexpr std::int64_t unwatched_every = 5;

}  // namespace

EmulatorServer::EmulatorServer(hal::EventLoop& loop, Emulator& emulator, EmulatorRecord& record)
    : emulator_(emulator),
      record_(record),
      start_(std::chrono::steady_clock::now()),
      pictures_(loop, emulator.config().listen, emulator.config().camera_port),
      control_(loop, emulator.config().listen, emulator.config().control_port,
               "the emulator's commands (emulator.control_port)",
               [this](std::string_view line) {
                 advance_to(std::chrono::steady_clock::now());
                 const std::string said = emulator_.command(line);
                 follow_plug();
                 serve_nodes();
                 return said;
               }),
      frame_due_(loop),
      line_full_(loop),
      picture_due_(loop) {
  const EmulatorConfig& config = emulator.config();
  if (emulator.nodes())
    nodes_.emplace(loop, config.listen, config.nodes_port, [this](const hal::aseba::Message& message) {
      advance_to(std::chrono::steady_clock::now());
      emulator_.nodes()->take(message);
      serve_nodes();
    });
  else
    reader_.emplace(loop, config.listen, config.ohc_port, config.ohc_link, [this](SerialReader::Chunk chunk) {
      if (chunk.refused) return counters_.add(plugged_ ? "serial.refused.in_use" : "serial.refused.unplugged");
      if (chunk.bytes.empty()) return drop_chunks();
      chunks_.push_back(std::move(chunk));
      if (chunks_.size() == 1) write_bytes();
    });
  wait_for_frame();
}

std::string EmulatorServer::url(std::size_t camera) const {
  const std::string& listen = emulator_.config().listen;
  const std::string host = listen == "0.0.0.0" || listen == "::"   ? "127.0.0.1"
                           : listen.find(':') == std::string::npos ? listen
                                                                   : "[" + listen + "]";
  return fmt::format("http://{}:{}/{}", host, pictures_.port(), emulator_.camera(camera).settings().name);
}

// From event to event, so that no unplugging is missed, however soon the file plugs in again.
void EmulatorServer::advance_to(TimePoint moment) {
  const hal::LabTime end = std::max(emulator_.now(), since_start(moment));
  for (const EmulatorConfig::Event& event : emulator_.config().events) {
    if (event.at <= emulator_.now() || event.at >= end) continue;
    emulator_.advance_to(event.at);
    follow_plug();
  }
  emulator_.advance_to(end);
  follow_plug();
  serve_nodes();
}

void EmulatorServer::serve_nodes() {
  if (!nodes_) return;
  if (std::exchange(cuts_, emulator_.nodes()->cuts()) != emulator_.nodes()->cuts()) nodes_->cut();
  nodes_->say(emulator_.nodes()->take_said());
}

// The emulator advances from chunk to chunk, so that each arrives at its own time.
void EmulatorServer::write_bytes() {
  while (!chunks_.empty()) {
    advance_to(chunks_.front().at);
    if (chunks_.empty()) return;  // unplugged on the way
    std::vector<std::uint8_t>& bytes = chunks_.front().bytes;
    const std::size_t fits = std::min(emulator_.serial_free(), bytes.size());
    emulator_.write_serial({bytes.data(), fits});
    reader_->done(fits);
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(fits));
    if (!bytes.empty()) break;
    chunks_.pop_front();
  }
  if (chunks_.empty()) return;
  line_full_.expires_after(look_at_full_line_after);
  line_full_.async_wait([this](auto error) {
    if (error) return;
    advance_to(std::chrono::steady_clock::now());
    write_bytes();
  });
}

// What was on its way to an unplugged controller is lost.
void EmulatorServer::follow_plug() {
  if (!reader_ || plugged_ == emulator_.ohc_plugged()) return;
  plugged_ = !plugged_;
  reader_->set_plugged(plugged_);
  drop_chunks();
  on_terminal_();
}

void EmulatorServer::drop_chunks() {
  for (const SerialReader::Chunk& chunk : chunks_) {
    reader_->done(chunk.bytes.size());
    counters_.add("serial.bytes_lost.cut_off", chunk.bytes.size());
  }
  chunks_.clear();
}

void EmulatorServer::wait_for_frame() {
  frame_due_.expires_at(start_ + frame_ * emulator_.config().frame_period);
  frame_due_.async_wait([this](auto error) {
    if (error) return;
    advance_to(std::chrono::steady_clock::now());
    take_pictures();
    wait_for_frame();
  });
}

void EmulatorServer::take_pictures() {
  const hal::LabTime period = emulator_.config().frame_period, wall = since_start(std::chrono::steady_clock::now());
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
      const hal::LabTime latency = emulator_.camera(k).settings().latency;
      if (latency.count() == 0)
        pictures_.show(name, std::as_bytes(std::span(jpeg)));
      else
        late_.emplace(start_ + emulator_.now() + latency, LatePicture{name, jpeg});
    }
    record_.add_picture(k, picture);
  }
  ++frame_;
  show_when_due();
}

void EmulatorServer::show_when_due() {
  for (; !late_.empty() && late_.begin()->first <= std::chrono::steady_clock::now(); late_.erase(late_.begin()))
    pictures_.show(late_.begin()->second.camera, std::as_bytes(std::span(late_.begin()->second.jpeg)));
  if (late_.empty()) return;
  picture_due_.expires_at(late_.begin()->first);
  picture_due_.async_wait([this](auto error) {
    if (!error) show_when_due();
  });
}

hal::Counters EmulatorServer::counters() const {
  hal::Counters out = emulator_.counters();
  for (const hal::Counters* part : {&counters_, &pictures_.counters(), &control_.counters()})
    for (const auto& [name, total] : part->all()) out.add(name, total);
  if (nodes_) out.merge(nodes_->counters());
  return out;
}

}  // namespace arkmesh::emulator
