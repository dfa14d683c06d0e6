#include "app/bus_view.hpp"

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <cstring>
#include <utility>

#include "arkmesh/pose_frame_t.hpp"
#include "hal/messages.hpp"

namespace arkmesh::app {
namespace {

constexpr std::size_t fingerprint_bytes = 8;
constexpr std::int64_t max_stamp_us = std::int64_t{1} << 53;  // what the page's numbers hold

// The stamp of a pose_frame_t, its first field: lab time ten times a second, where the status has it once.
std::int64_t stamp_of(std::span<const std::byte> poses) {
  std::int64_t stamp = 0;
  if (poses.size() < fingerprint_bytes + sizeof stamp) return 0;
  std::memcpy(&stamp, poses.data() + fingerprint_bytes, sizeof stamp);
  return std::clamp<std::int64_t>(boost::endian::big_to_native(stamp), 0, max_stamp_us);
}

}  // namespace

BusView::BusView(hal::EventLoop& loop, const hal::BusConfig& bus, std::string lab, view::ServerOptions options)
    : bus_(bus.url, bus.hear),
      lab_(std::move(lab)),
      server_(loop, std::move(options), *this),
      heard_(bus_.subscribe(".*", [this](auto channel, auto bytes) { hear(channel, bytes); })),
      readable_(loop, bus_.descriptor(), [this] { bus_.drain(); }) {}

void BusView::hear(std::string_view channel, std::span<const std::byte> bytes) {
  if (channel == hal::channel::poses) newest_us_ = stamp_of(bytes);
  if (channel == hal::channel::status)
    for (const std::string& line : news_.read(bytes)) server_.tell(0, news_.stamp_us(), line);
  server_.show(0, newest_us_, channel, bytes);
}

nlohmann::json BusView::about() {
  const std::string& name = lab_.empty() ? news_.lab() : lab_;
  return {{"mode", "live"},
          {"labs", {name.empty() ? "lab" : name}},
          {"control", false},
          {"run", bus_.url()},
          {"emulator", {false}}};
}

void BusView::command(const nlohmann::json&, view::Answer& answer) {
  answer.refuse(
      "This page only shows the lab; commands are given at the page that the lab itself prints, or by arkmesh stop.");
}

void BusView::request(const nlohmann::json&, view::Answer& answer) {
  answer.refuse("This lab runs now; what it did before is in its run folder: arkmesh view FOLDER.");
}

}  // namespace arkmesh::app
