// The page of all labs of a federation that are trusted, from what they let be watched. Shows and commands nothing.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "app/live/lab_feed.hpp"
#include "gateway/federation/watcher.hpp"
#include "hal/event_loop.hpp"
#include "view/server.hpp"

namespace arkmesh::app {

struct WatchedFederation {
  std::string servers;  // as gateway.connect has them
  std::string experiment;
  gateway::KeyFolder keys;
  std::string name;  // whose key there it watches with; empty: the only one
  gateway::FederationOptions options;
};

class FederationView final : public view::Desk {
 public:
  // The loop outlives it. Throws hal::ConfigError: the servers' list is wrong, there is no such key, or nobody is
  // trusted; std::runtime_error when there is no port for the page.
  FederationView(hal::EventLoop& loop, const WatchedFederation& federation, view::ServerOptions options);

  std::string url() const { return server_.url(); }
  std::uint16_t port() const { return server_.port(); }

  nlohmann::json about() override;
  void command(const nlohmann::json& what, view::Answer& answer) override;
  void request(const nlohmann::json& what, view::Answer& answer) override;
  // Says in the event log how the connection is, and what was refused, when that changes.
  void refresh() override;

 private:
  const std::string run_;
  std::vector<std::string> labs_;         // ascending
  std::map<std::string, LabFeed> feeds_;  // of each
  std::string said_;
  std::set<std::string> refused_;  // reasons that were said
  view::Server server_;
  std::unique_ptr<gateway::Watcher> watcher_;
};

}  // namespace arkmesh::app
