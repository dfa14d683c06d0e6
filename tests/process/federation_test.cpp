// Labs that meet at a real NATS server, as processes. tests/campaign/campaign kills the server, and cuts and slows
// links to it.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "gateway/federation/watcher.hpp"
#include "lab/result.hpp"
#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/network/nats_server.hpp"
#include "tests/support/network/tcp_bench.hpp"
#include "tests/support/network/test_keys.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using tests::LabProcesses;

namespace {

const std::string duration = "run.duration_s=300";

const std::string& reference() {
  static const std::string hash = lab::hash_text(tests::run_labs({.overrides = {duration}}).hash);
  return hash;
}

// Both labs trust each other and a watcher.
struct FederatedLabs {
  tests::TestKeys keys;
  tests::NatsServerProcess server;
  LabProcesses labs;

  FederatedLabs()
      : labs({.overrides = {duration, "gateway.peers=[]", "gateway.listen=\"\"", "gateway.encrypt=true"},
              .by_lab = {{"shark", sets("shark")}, {"roark", sets("roark")}},
              .first_port = 7940}) {}

  std::vector<std::string> sets(const std::string& lab) const {
    for (const char* other : {"shark", "roark", "ann"})
      if (other != lab) keys.join(lab, other);
    return {fmt::format("gateway.connect=\"nats://127.0.0.1:{}\"", server.port()),
            fmt::format("gateway.keys=\"{}\"", keys.of(lab).path().string())};
  }
  void check() {
    REQUIRE(labs.ended(300s));
    for (const char* lab : {"shark", "roark"}) {
      CAPTURE(labs.lab_output(lab));
      CAPTURE(labs.gateway_output(lab));
      CHECK(labs.result(lab, "final_hash") == reference());
    }
  }
};

}  // namespace

TEST_CASE("labs that meet at a server have the hash of one process, watched or not") {
  // A watcher that is trusted sees what the labs' own page would show, though all is encrypted; it publishes nothing,
  // and another one that the labs do not trust sees nothing.
  FederatedLabs bench;
  bench.keys.trust("stranger", "shark");
  boost::asio::io_context io;
  std::map<std::pair<std::string, std::string>, int> seen, seen_by_stranger;
  const auto watch = [&](const std::string& name, auto& into) {
    return gateway::Watcher(io, gateway::read_servers(bench.server.address(), false), {}, name, "dhtf",
                            bench.keys.tls(name), [&into](const std::string& lab, std::string_view channel, auto) {
                              ++into[{lab, std::string(channel)}];
                            });
  };
  const gateway::Watcher ann = watch("ann", seen), stranger = watch("stranger", seen_by_stranger);
  bench.labs.start();
  CHECK(tests::run_until(io, [&] {
    for (const char* lab : {"shark", "roark"})
      for (const char* channel : {"arena", "poses", "overlay", "shared", "status", "peers"})
        if (!seen.contains({lab, channel})) return false;
    return true;
  }));
  bench.check();
  CHECK(seen_by_stranger.empty());
  CHECK(stranger.counters()["federation.refused.no_key.shark"] > 0);
  CHECK(stranger.counters()["federation.refused.not_trusted"] > 0);
}
