#include "app/live/bus_view.hpp"

#include <utility>

namespace arkmesh::app {
BusView::BusView(hal::EventLoop& loop, const hal::BusConfig& bus, std::string lab, view::ServerOptions options)
    : bus_(bus.url, bus.hear),
      lab_(std::move(lab)),
      server_(loop, std::move(options), *this),
      heard_(bus_.subscribe(".*", [this](auto channel, auto bytes) { feed_.hear(server_, 0, channel, bytes); })),
      readable_(loop, bus_.descriptor(), [this] { bus_.drain(); }) {}

std::string BusView::name() const {
  const std::string& name = lab_.empty() ? feed_.name() : lab_;
  return name.empty() ? "lab" : name;
}

nlohmann::json BusView::about() {
  return {{"mode", "live"}, {"labs", {name()}}, {"control", false}, {"run", bus_.url()}, {"emulator", {false}}};
}

void BusView::command(const nlohmann::json&, view::Answer& answer) {
  answer.refuse(
      "This page is read-only; give commands on the lab's own page, whose URL the lab prints, or with arkmesh stop.");
}

void BusView::request(const nlohmann::json& what, view::Answer& answer) {
  if (!what.contains("series"))
    return answer.refuse("This lab is running; to see earlier moments, open its run folder: arkmesh view FOLDER.");
  if (!answer.done({{"series", feed_.history().series(name())}}))
    answer.refuse("the curves cannot be sent now; try again later");
}

}  // namespace arkmesh::app
