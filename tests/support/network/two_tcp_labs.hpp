// Two whole gateways, each on its lab's bus, with a proxy between them that makes the network as bad as a test wants.
#pragma once

#include <doctest/doctest.h>

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gateway/gateway.hpp"
#include "gateway/links/connections.hpp"
#include "hal/bus/bus.hpp"
#include "tests/support/network/impairment_proxy.hpp"
#include "tests/support/network/tcp_bench.hpp"

namespace arkmesh::tests {

inline const std::vector<gateway::Rule> exports = {{"world", gateway::Delivery::latest},
                                                   {"status", gateway::Delivery::latest},
                                                   {"events", gateway::Delivery::ordered}};

// One lab: its bus, what was heard on it, its gateway.
struct TcpLab {
  hal::Bus bus{"memq://"};
  std::vector<std::pair<std::string, std::string>> heard;
  std::unique_ptr<hal::Bus::Subscription> foreign =
      bus.subscribe("[^/]+/.*", [this](std::string_view channel, auto bytes) {
        heard.emplace_back(channel, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
      });
  std::unique_ptr<gateway::Connections> node;
  std::unique_ptr<gateway::Gateway> gateway;

  void publish(const std::string& channel, std::string_view text) {
    bus.publish(channel, std::as_bytes(std::span(text)));
  }
  const gateway::Link& link() const { return *gateway->links().front(); }
  bool up() const { return link().stats().up; }
  std::uint64_t count(std::string_view name) const { return link().stats().counters[name]; }
  bool heard_last(const std::string& channel, const std::string& text) const {
    return !heard.empty() && heard.back() == std::pair(channel, text);
  }
};

// shark listens, roark connects through the proxy.
struct TwoTcpLabs {
  boost::asio::io_context io;
  TcpLab shark, roark;
  std::unique_ptr<ImpairmentProxy> proxy;
  std::uint64_t boots = 100;

  explicit TwoTcpLabs(const Impairment& impairment = {}) {
    start_shark("127.0.0.1:0");
    proxy = std::make_unique<ImpairmentProxy>(shark.node->listening().port());
    proxy->set(impairment);
    start_roark();
  }
  void start_shark(const std::string& listen) {
    gateway::TcpSettings settings = tcp_settings("shark", ++boots);
    settings.listen = listen;
    start(shark, std::move(settings), "roark", "");
  }
  void start_roark() {
    start(roark, tcp_settings("roark", ++boots), "shark", "127.0.0.1:" + std::to_string(proxy->port()));
  }
  void start(TcpLab& lab, gateway::TcpSettings settings, const std::string& peer, const std::string& connect) {
    lab.gateway.reset();
    lab.node.reset();
    const std::string name = settings.lab;
    const std::uint64_t boot = settings.boot_id;
    lab.node = std::make_unique<gateway::Connections>(io, std::move(settings));
    std::vector<std::unique_ptr<gateway::Link>> links;
    links.push_back(lab.node->link(peer, connect));
    lab.gateway = std::make_unique<gateway::Gateway>(
        lab.bus, name, boot, gateway::ChannelRules(exports, {"world", "status", "events"}), std::move(links));
    lab.gateway->start();
  }
  template <class Condition>
  bool until(Condition condition) {
    return run_until(io, [&] {
      shark.bus.drain();
      roark.bus.drain();
      return condition();
    });
  }
  bool both(bool up) {
    return until([&] { return shark.up() == up && roark.up() == up; });
  }
  // A message each way arrives.
  void check_passage(const std::string& text = "through") {
    REQUIRE(both(true));
    shark.publish("world", text);
    roark.publish("world", text);
    CHECK(until([&] { return shark.heard_last("roark/world", text) && roark.heard_last("shark/world", text); }));
  }
};

}  // namespace arkmesh::tests
