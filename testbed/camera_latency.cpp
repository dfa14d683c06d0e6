#include "testbed/camera_latency.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>

#include "hal/platforms/kilobot/packet.hpp"

namespace arkmesh::testbed {
namespace {

using namespace std::chrono_literals;
using Kind = hal::FleetCommand::Kind;

constexpr hal::LabTime fine{500}, coarse{5'000};
constexpr hal::LabTime lit_for = 900ms;    // the controller is silent again, and all robots have heard it
constexpr hal::LabTime dark_for = 1200ms;  // likewise, and the latest camera has shown it
constexpr hal::LabTime sent_within = 5s;
// From the end of a packet on the line to the end of its message, when a robot obeys: of the published firmware.
constexpr hal::LabTime message_takes{4'571};
constexpr int difference = 40;  // of 255, in pixels that show an LED
constexpr int saturated = 240;
constexpr int min_pixels = 5;
constexpr double golden = 0.618033988749895;  // so that moments are spread evenly, however many there are

// What one camera gave around one flash.
struct Frame {
  hal::LabTime arrived;
  cv::Mat light;  // the brightest of each pixel's colours, 8 bit
};

cv::Mat light_of(const cv::Mat& bgr) {
  cv::Mat light;
  cv::reduce(bgr.clone().reshape(1, static_cast<int>(bgr.total())), light, 1, cv::REDUCE_MAX);
  return light;
}

// Which part of the light that goes out is in each frame, 1 in the first and 0 in the last. Empty: none goes out.
std::vector<double> lit_parts(const std::vector<Frame>& frames) {
  if (frames.size() < 3) return {};
  cv::Mat fades, mask;
  cv::subtract(frames.front().light, frames.back().light, fades);
  // what saturates is as bright at half of the light
  mask = (fades > difference) & (frames.front().light < saturated);
  if (cv::countNonZero(mask) < min_pixels) return {};
  const double all = cv::mean(frames.front().light, mask)[0], none = cv::mean(frames.back().light, mask)[0];
  std::vector<double> out;
  for (const Frame& frame : frames) out.push_back((cv::mean(frame.light, mask)[0] - none) / (all - none));
  return out;
}

class Flashes {
 public:
  explicit Flashes(SetUpArena& arena) : arena_(arena), frames_(arena.tracks()->last_look().pictures.size()) {}

  // True: a camera may have seen it.
  void flash(double phase) {
    arena_.robots().command({.kind = Kind::voltage});
    pass(lit_for, coarse);
    const hal::LabTime period = arena_.info().frame_period;
    pass(period - arena_.now() % period + hal::LabTime(std::llround(phase * static_cast<double>(period.count()))),
         fine);
    // what is lit
    for (std::vector<Frame>& frames : frames_)
      if (frames.size() > 1) frames.erase(frames.begin(), frames.end() - 1);
    const hal::LabTime sent = send_pause();
    pass(dark_for, coarse);
    const hal::LabTime dark = sent + offset_ + hal::kilobot::packet_on_line + message_takes;
    for (std::size_t camera = 0; camera < frames_.size(); ++camera) {
      const std::vector<Frame> frames = std::exchange(frames_[camera], {});
      const std::vector<double> lit = lit_parts(frames);
      const auto first_dark =
          static_cast<std::size_t>(std::ranges::find_if(lit, [](double part) { return part < 0.5; }) - lit.begin());
      if (!lit.empty())
        seen_[camera].push_back({frames[first_dark - 1].arrived - dark, frames[first_dark].arrived - dark});
    }
  }

  std::vector<CameraLatency> results() {
    std::vector<CameraLatency> out;
    for (std::size_t camera = 0; camera < frames_.size(); ++camera) out.push_back(latency_of(seen_[camera]));
    return out;
  }

 private:
  void pass(hal::LabTime span, hal::LabTime step) {
    for (const hal::LabTime end = arena_.now() + span; arena_.now() < end;) {
      arena_.wait(std::min(step, end - arena_.now()));
      note_look();
    }
  }

  void note_look() {
    const LastLook& look = arena_.tracks()->last_look();
    if (look.now == noted_) return;
    noted_ = look.now;
    // a look may be late, never early
    offset_ = std::min(offset_, look.now - arena_.now() / arena_.info().frame_period * arena_.info().frame_period);
    for (std::size_t camera = 0; camera < look.pictures.size(); ++camera)
      if (!look.pictures[camera].empty())
        frames_[camera].push_back({look.arrived[camera], light_of(look.pictures[camera])});
  }

  // When its first packet went out.
  hal::LabTime send_pause() {
    const auto sent = [this] { return arena_.arena().counters()["fleet_command.sent"]; };
    const std::uint64_t before = sent();
    arena_.robots().command({.kind = Kind::pause});
    for (const hal::LabTime end = arena_.now() + sent_within; arena_.now() < end;) {
      const hal::LabTime at = arena_.now();
      pass(fine, fine);
      if (sent() > before) return at;
    }
    throw std::runtime_error("the overhead controller accepts no command: it cannot flash the LEDs");
  }

  SetUpArena& arena_;
  hal::LabTime noted_{-1}, offset_ = hal::LabTime::max();  // from lab time to the time of looks
  std::vector<std::vector<Frame>> frames_;                 // of each camera
  std::map<std::size_t, std::vector<FlashSeen>> seen_;     // by camera
};

}  // namespace

CameraLatency latency_of(const std::vector<FlashSeen>& flashes) {
  std::vector<std::pair<hal::LabTime, int>> bounds;
  for (const FlashSeen& flash : flashes) {
    bounds.emplace_back(flash.least, 1);
    bounds.emplace_back(flash.most, -1);
  }
  std::ranges::sort(bounds);
  CameraLatency out{.flashes = static_cast<int>(flashes.size())};
  int allowed = 0;
  for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
    allowed += bounds[i].second;
    if (allowed <= out.agree) continue;
    out.agree = allowed;
    const double least = static_cast<double>(bounds[i].first.count()),
                 most = static_cast<double>(bounds[i + 1].first.count());
    out.latency_ms = (least + most) / 2000;
    out.within_ms = (most - least) / 2000;
  }
  return out;
}

std::vector<CameraLatency> measure_latency(SetUpArena& arena, int flashes, hal::StopRequest& stop,
                                           hal::Progress& progress) {
  if (!arena.tracks()) throw std::runtime_error("this arena has no cameras, so there is no latency to measure");
  for (int i = 0; i < 10; ++i) arena.next_picture({});
  Flashes all(arena);
  for (int i = 0; i < flashes && !stop.stopped(); ++i) {
    all.flash(std::fmod(i * golden, 1.0));
    progress.show(fmt::format("{:.1f} s, {} of {} flashes", arena.seconds(), i + 1, flashes));
  }
  progress.done();
  return all.results();
}

}  // namespace arkmesh::testbed
