#include "app/live/federation_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "gateway/links/links.hpp"
#include "hal/config/config.hpp"
#include "hal/config/without_secrets.hpp"

namespace arkmesh::app {
namespace {

gateway::NatsServers servers_of(const std::string& connect) {
  if (!gateway::is_nats(connect))
    throw hal::ConfigError(fmt::format("--federation {}: must begin with nats:// or tls+nats://", connect));
  if (const std::string why = gateway::why_not_connectable(connect); !why.empty())
    throw hal::ConfigError(fmt::format("--federation {}: {}", connect, why));
  const bool tls = connect.starts_with("tls+");
  return gateway::read_servers(std::string_view(connect).substr(connect.find("://") + 3), tls);
}

// Whose key it is.
std::string name_of(const WatchedFederation& federation, const gateway::KeyFolder::Listing& listing) {
  if (!federation.name.empty()) return federation.name;
  if (listing.own.size() == 1) return listing.own.front().lab;
  if (listing.own.empty())
    throw hal::ConfigError(
        fmt::format("{} holds no spectator key; create one with arkmesh keys init NAME, then have the labs run arkmesh "
                    "keys trust NAME.crt",
                    federation.keys.path().string()));
  throw hal::ConfigError(fmt::format("{} holds {} keys; choose one: --as {}", federation.keys.path().string(),
                                     listing.own.size(), listing.own.front().lab));
}

std::vector<std::string> trusted_labs(const WatchedFederation& federation, const gateway::KeyFolder::Listing& listing) {
  std::vector<std::string> labs;
  for (const gateway::Certificate& each : listing.trusted) labs.push_back(each.lab);
  std::ranges::sort(labs);
  if (labs.empty())
    throw hal::ConfigError(
        fmt::format("{} trusts no lab, so there is nothing to show; obtain the labs' certificates and run arkmesh keys "
                    "trust LAB.crt",
                    federation.keys.path().string()));
  return labs;
}

}  // namespace

FederationView::FederationView(hal::EventLoop& loop, const WatchedFederation& federation, view::ServerOptions options)
    : run_(hal::without_secrets(federation.servers)),
      labs_(trusted_labs(federation, federation.keys.list())),
      server_(loop, std::move(options), *this) {
  const std::string name = name_of(federation, federation.keys.list());
  for (const std::string& lab : labs_) feeds_[lab];
  watcher_ = std::make_unique<gateway::Watcher>(
      loop, servers_of(federation.servers), federation.options, name, federation.experiment,
      std::make_shared<gateway::TlsKeys>(federation.keys, name),
      [this](const std::string& lab, std::string_view channel, std::span<const std::byte> bytes) {
        const auto feed = feeds_.find(lab);
        if (feed == feeds_.end()) return;  // trusted since
        const auto number = static_cast<int>(std::ranges::find(labs_, lab) - labs_.begin());
        feed->second.hear(server_, number, channel, bytes);
      });
}

nlohmann::json FederationView::about() {
  const std::vector<bool> emulator(labs_.size(), false);
  return {{"mode", "live"}, {"labs", labs_}, {"control", false}, {"run", run_}, {"emulator", emulator}};
}

void FederationView::command(const nlohmann::json&, view::Answer& answer) {
  answer.refuse("This page is read-only; give commands where the labs run.");
}

void FederationView::request(const nlohmann::json& what, view::Answer& answer) {
  if (!what.contains("series"))
    return answer.refuse("These labs are running; earlier moments are in their run folders.");
  nlohmann::json all = nlohmann::json::array();
  for (const std::string& lab : labs_)
    for (auto& row : feeds_.at(lab).history().series(lab)) all.push_back(std::move(row));
  if (!answer.done({{"series", all}})) answer.refuse("the curves cannot be sent now; try again later");
}

void FederationView::refresh() {
  if (said_ != watcher_->why()) server_.tell(-1, 0, said_ = watcher_->why());
  const hal::Counters counters = watcher_->counters();
  for (const auto& [name, n] : counters.all())
    if (name.find(".refused.") != std::string::npos && refused_.insert(name).second)
      server_.tell(-1, 0, fmt::format("not shown: {}", name));
}

}  // namespace arkmesh::app
