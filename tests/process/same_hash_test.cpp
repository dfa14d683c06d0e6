#include <doctest/doctest.h>
#include <fmt/format.h>

#include <csignal>
#include <string>

#include "hal/record/event_log.hpp"
#include "lab/result.hpp"
#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/network/impairment_proxy.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using tests::LabProcesses;

namespace {

// One process, the same seed: what every run of processes must give. 600 simulated seconds, 300 periods.
const std::string& reference() {
  static const std::string hash = lab::hash_text(tests::run_labs({.overrides = {"run.duration_s=600"}}).hash);
  return hash;
}

const std::vector<std::string> shortened = {"run.duration_s=600"};

// Two labs that a proxy between their gateways holds at about four fifths of the run (roark sends some 800 bytes each
// period), until the test, late as it may be on a busy machine, has done its fault and lets them go on.
struct Held {
  tests::ImpairmentProxy proxy{7901};
  LabProcesses labs{{.overrides = shortened, .through_port = {{{"roark", "shark"}, proxy.port()}}, .first_port = 7900}};
  Held() {
    proxy.set({.hold_after = 190'000});
    labs.start();
  }
  void go_on() { proxy.set({}); }
};

void check_same(LabProcesses& labs) {
  for (const char* lab : {"shark", "roark"}) {
    CAPTURE(labs.lab_output(lab));
    CAPTURE(labs.gateway_output(lab));
    REQUIRE(labs.lab(lab).wait(0ms) == 0);
    CHECK(labs.result(lab, "final_hash") == reference());
    CHECK(labs.result(lab, "ended") == "finished");
  }
}

}  // namespace

TEST_CASE("four processes over TCP have the hash of one process") {
  // Proves that a lab's result is independent of how the labs are joined.
  LabProcesses labs({.overrides = shortened});
  labs.start();
  REQUIRE(labs.ended(300s));
  check_same(labs);
}

TEST_CASE("six processes of three labs have the hash of one process") {
  // Proves the same with a link for every pair.
  const std::string expected =
      lab::hash_text(tests::run_labs({.labs = {"shark", "roark", "lynx"}, .overrides = {"run.duration_s=600"}}).hash);
  LabProcesses labs({.labs = {"shark", "roark", "lynx"}, .overrides = shortened});
  labs.start();
  REQUIRE(labs.ended(300s));
  for (const char* lab : {"shark", "roark", "lynx"}) {
    CAPTURE(labs.lab_output(lab));
    CHECK(labs.result(lab, "final_hash") == expected);
  }
}

TEST_CASE("a gateway killed in mid-run and started again changes nothing") {
  // Proves that gateways hold nothing that a result needs, and come back by themselves.
  for (const char* killed : {"roark", "shark"}) {
    Held held;
    LabProcesses& labs = held.labs;
    REQUIRE(labs.reached("shark", 30, 300s));
    labs.gateway(killed).kill();
    const std::int64_t at = labs.period("shark", 200ms);
    REQUIRE(at < 300);  // in mid-run
    // Both labs stop at most one period later, and stay there.
    for (const auto until = std::chrono::steady_clock::now() + 2s; std::chrono::steady_clock::now() < until;)
      labs.period("shark", 50ms);
    CHECK(labs.period("shark") <= at + 1);
    CHECK(std::abs(labs.period("shark") - labs.period("roark")) <= 1);
    held.go_on();
    labs.start_gateway(killed);
    REQUIRE(labs.ended(300s));
    check_same(labs);
  }
}

TEST_CASE("both gateways killed stop all labs; started again they finish the run") {
  // Proves that the labs share nothing but what goes through their gateways.
  Held held;
  LabProcesses& labs = held.labs;
  REQUIRE(labs.reached("roark", 30, 300s));
  labs.gateway("roark").kill();
  labs.gateway("shark").kill();
  for (const auto until = std::chrono::steady_clock::now() + 2s; std::chrono::steady_clock::now() < until;)
    labs.period("shark", 50ms);
  const std::int64_t shark = labs.period("shark"), roark = labs.period("roark");
  REQUIRE(shark < 300);
  CHECK(std::abs(shark - roark) <= 1);
  for (const auto until = std::chrono::steady_clock::now() + 1s; std::chrono::steady_clock::now() < until;)
    labs.period("shark", 50ms);
  CHECK(labs.period("shark") == shark);
  held.go_on();
  labs.start_gateway("roark");
  labs.start_gateway("shark");
  REQUIRE(labs.ended(300s));
  check_same(labs);
}
