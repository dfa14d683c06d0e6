// The page of a lab that runs elsewhere, from what it says on its public bus. Shows and commands nothing: operators
// give commands where the lab runs.
#pragma once

#include <memory>
#include <string>

#include "app/live/lab_feed.hpp"
#include "hal/bus/bus.hpp"
#include "hal/bus/bus_config.hpp"
#include "hal/event_loop.hpp"
#include "hal/on_loop.hpp"
#include "view/server.hpp"

namespace arkmesh::app {

class BusView final : public view::Desk {
 public:
  // `lab`: its name; empty: as its status says. The loop outlives it. Throws std::runtime_error, in one sentence, when
  // there is no such bus or no port for the page.
  BusView(hal::EventLoop& loop, const hal::BusConfig& bus, std::string lab, view::ServerOptions options);

  std::string url() const { return server_.url(); }
  std::uint16_t port() const { return server_.port(); }

  nlohmann::json about() override;
  void command(const nlohmann::json& what, view::Answer& answer) override;
  void request(const nlohmann::json& what, view::Answer& answer) override;

 private:
  std::string name() const;

  hal::Bus bus_;
  std::string lab_;
  LabFeed feed_;
  view::Server server_;
  std::unique_ptr<hal::Bus::Subscription> heard_;
  hal::Readable readable_;
};

}  // namespace arkmesh::app
