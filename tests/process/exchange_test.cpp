// Event-based and mixed exchange between real processes: strict labs keep their hash through every fault.
#include <doctest/doctest.h>

#include <chrono>
#include <string>
#include <vector>

#include "lab/result.hpp"
#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/network/impairment_proxy.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using tests::ImpairmentProxy;
using tests::LabProcesses;

namespace {

// What roark has sent by about the middle of a run: there the proxy holds both labs until a test has done its last
// fault.
constexpr std::size_t middle_bytes = 80'000;

// shark listens on 7941; roark reaches it through the proxy. 600 simulated seconds, 300 periods.
struct Exchanging {
  std::vector<std::string> overrides;
  ImpairmentProxy proxy{7941};
  LabProcesses labs;
  explicit Exchanging(std::vector<std::string> exchange)
      : overrides(std::move(exchange)),
        labs({.overrides = overrides, .through_port = {{{"roark", "shark"}, proxy.port()}}, .first_port = 7940}) {
    impair({});
    labs.start();
  }
  // Of the labs before the middle.
  void impair(tests::Impairment impairment) {
    impairment.hold_after = middle_bytes;
    proxy.set(impairment);
  }
  void watch(std::chrono::milliseconds how_long) {
    for (const auto until = std::chrono::steady_clock::now() + how_long; std::chrono::steady_clock::now() < until;)
      labs.period("shark", 50ms);
  }
  void check() {
    const bool ended = labs.ended(300s);
    CAPTURE(labs.lab_output("shark"));
    CAPTURE(labs.lab_output("roark"));
    REQUIRE(ended);
    const std::string expected = lab::hash_text(tests::run_labs({.overrides = overrides}).hash);
    CHECK(labs.result("shark", "final_hash") == expected);
    CHECK(labs.result("roark", "final_hash") == expected);
  }
};

std::vector<std::string> exchange(const char* mode, const char* more = "run.duration_s=600") {
  return {std::string("gate.exchange=") + mode, "run.duration_s=600", more};
}

}  // namespace

TEST_CASE("by events and mixed, faults of the network in mid-run change nothing") {
  // Proves that no lost, late or repeated event makes the labs' worlds differ: a delay, flipped bits, connections that
  // are reset, a link that is cut and heals.
  for (const auto& overrides : {exchange("event"), exchange("mixed"), exchange("mixed", "gate.down_period_s=6")}) {
    CAPTURE(overrides.front() + " " + overrides.back());
    Exchanging p(overrides);
    REQUIRE(p.labs.reached("shark", 20, 300s));
    p.impair({.delay = 10ms, .jitter = 10ms});
    REQUIRE(p.labs.reached("shark", 40, 300s));
    p.impair({.corrupt_every = 5000});
    REQUIRE(p.labs.reached("shark", 60, 300s));
    p.impair({});
    REQUIRE(p.proxy.counts().corrupted > 0);
    p.proxy.reset();
    REQUIRE(p.labs.reached("shark", 70, 300s));
    p.proxy.refuse(true);
    const std::int64_t at = p.labs.period("shark", 100ms);
    REQUIRE(at < 280);  // in mid-run
    p.watch(3s);
    CHECK(p.labs.period("shark") <= at + 1);
    p.proxy.refuse(false);
    p.proxy.set({});
    p.check();
    CHECK(p.proxy.counts().connections > 2);
  }
}

TEST_CASE("by events, a gateway killed in mid-run and started again changes nothing") {
  // Proves that no event is lost with the gateway that held it.
  Exchanging p(exchange("event"));
  for (const char* killed : {"roark", "shark"}) {
    REQUIRE(p.labs.reached("shark", std::string(killed) == "roark" ? 30 : 60, 300s));
    p.labs.gateway(killed).kill();
    REQUIRE(p.labs.period("shark", 200ms) < 280);
    p.watch(1s);
    p.labs.start_gateway(killed);
  }
  p.proxy.set({});
  p.check();
}
