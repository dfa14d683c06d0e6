#include "app/live/bus_view.hpp"

#include <algorithm>
#include <utility>

#include "app/live/frame_part.hpp"
#include "hal/messages.hpp"

namespace arkmesh::app {
namespace {

constexpr std::int64_t max_stamp_us = std::int64_t{1} << 53;  // what the page's numbers hold

}  // namespace

BusView::BusView(hal::EventLoop& loop, const hal::BusConfig& bus, std::string lab, view::ServerOptions options)
    : bus_(bus.url, bus.hear),
      lab_(std::move(lab)),
      server_(loop, std::move(options), *this),
      heard_(bus_.subscribe(".*", [this](auto channel, auto bytes) { hear(channel, bytes); })),
      readable_(loop, bus_.descriptor(), [this] { bus_.drain(); }) {}

void BusView::hear(std::string_view channel, std::span<const std::byte> bytes) {
  view::Part part;
  // lab time ten times a second, where the status has it once
  if (const auto frame = frame_part(channel, bytes)) {
    newest_us_ = std::min(frame->stamp_us, max_stamp_us);
    part = frame->part;
  }
  if (channel == hal::channel::status) {
    for (const std::string& line : news_.read(bytes)) server_.tell(0, news_.stamp_us(), line);
    history_.note(news_.stamp_us(), news_.counts());
  }
  server_.show(0, newest_us_, channel, bytes, part);
}

std::string BusView::name() const {
  const std::string& name = lab_.empty() ? news_.lab() : lab_;
  return name.empty() ? "lab" : name;
}

nlohmann::json BusView::about() {
  return {{"mode", "live"}, {"labs", {name()}}, {"control", false}, {"run", bus_.url()}, {"emulator", {false}}};
}

void BusView::command(const nlohmann::json&, view::Answer& answer) {
  answer.refuse(
      "This page only shows the lab; commands are given at the page that the lab itself prints, or by arkmesh stop.");
}

void BusView::request(const nlohmann::json& what, view::Answer& answer) {
  if (!what.contains("series"))
    return answer.refuse("This lab runs now; what it did before is in its run folder: arkmesh view FOLDER.");
  if (!answer.done({{"series", history_.series(name())}}))
    answer.refuse("there is no room for the curves now; ask again later");
}

}  // namespace arkmesh::app
