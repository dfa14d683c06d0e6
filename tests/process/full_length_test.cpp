// The faults of the other files in runs of full length: 1800 simulated seconds, faults at periods 300 and 500. Skipped
// by ctest (they take minutes); scripts/measure runs each by name and shows what its MESSAGE says.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "lab/result.hpp"
#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/network/impairment_proxy.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using tests::ImpairmentProxy;
using tests::LabProcesses;

namespace {

constexpr std::int64_t last_period = 900;

const std::string& reference() {
  static const std::string hash = lab::hash_text(tests::run_labs({.overrides = {"run.duration_s=1800"}}).hash);
  return hash;
}

// shark listens on 7871; roark reaches it through the proxy at 7875: a port that the system gives to nobody while the
// link is cut.
struct Run {
  ImpairmentProxy proxy{7871, 7875};
  LabProcesses labs{
      {.overrides = {"run.duration_s=1800"}, .through_port = {{{"roark", "shark"}, proxy.port()}}, .first_port = 7870}};
  Run() { labs.start(); }

  // Lets the run come to `period`, which must not be its end.
  std::int64_t come_to(std::int64_t period) {
    REQUIRE(labs.reached("shark", period, 120s));
    const std::int64_t at = std::max(labs.period("shark"), labs.period("roark"));
    REQUIRE(at < last_period);
    return at;
  }
  void wait(std::chrono::seconds time) {
    for (const auto until = std::chrono::steady_clock::now() + time; std::chrono::steady_clock::now() < until;)
      labs.period("shark", 100ms);
  }
  // Waits for the end and compares.
  void check() {
    REQUIRE(labs.ended(500s));
    for (const char* lab : {"shark", "roark"}) {
      CAPTURE(labs.lab_output(lab));
      CAPTURE(labs.gateway_output(lab));
      CHECK(labs.result(lab, "ended") == "finished");
      CHECK(labs.result(lab, "final_hash") == reference());
    }
  }
  // Tells what happened in mid-run.
  void tell(const std::string& what) { MESSAGE(fmt::format("{}; hash {}", what, labs.result("shark", "final_hash"))); }
};

}  // namespace

TEST_CASE("full length: delay of 20 ms" * doctest::skip()) {
  // From period 300 to 500 every byte is 20 ms late, each way: the labs slow down to it, and the hash stays.
  Run run;
  const std::int64_t from = run.come_to(300);
  run.proxy.set({.delay = 20ms});
  const auto begun = std::chrono::steady_clock::now();
  const std::int64_t to = run.come_to(500);
  const auto took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun);
  run.proxy.set({});
  CHECK(took > 20ms * (to - from - 2));
  run.check();
  run.tell(fmt::format("delayed from period {} to {}, {:.1f} ms a period", from, to,
                       took.count() * 1e3 / static_cast<double>(to - from)));
}

TEST_CASE("full length: slices of 1 byte" * doctest::skip()) {
  // From period 300 on the stream comes in single bytes.
  Run run;
  const std::int64_t from = run.come_to(300);
  const auto before = run.proxy.counts();
  run.proxy.set({.slice_bytes = 1});
  run.check();
  CHECK(run.proxy.counts().writes > before.writes + 100'000);
  run.tell(fmt::format("sliced from period {} on, {} writes", from, run.proxy.counts().writes - before.writes));
}

TEST_CASE("full length: corrupted bytes" * doctest::skip()) {
  // From period 300 to 500 one bit of every 20000 bytes is flipped: sessions close, nothing false is believed.
  Run run;
  const std::int64_t from = run.come_to(300);
  run.proxy.set({.corrupt_every = 20'000});
  const std::int64_t to = run.come_to(500);
  run.proxy.set({});
  const auto counts = run.proxy.counts();
  CHECK(counts.corrupted > 5);
  CHECK(counts.connections > 3);
  run.check();
  run.tell(
      fmt::format("{} bits flipped from period {} to {}, {} sessions", counts.corrupted, from, to, counts.connections));
}

TEST_CASE("full length: cut of 30 s" * doctest::skip()) {
  // At period 300 the link is cut for 30 s of wall time: the labs stop, and go on where they were.
  Run run;
  const std::int64_t at = run.come_to(300);
  run.proxy.refuse(true);
  run.wait(30s);
  const std::int64_t still = run.labs.period("shark");
  CHECK(still <= at + 5);  // what was on its way when the cut came
  run.proxy.refuse(false);
  run.check();
  run.tell(fmt::format("cut at period {}, at {} after 30 s", at, still));
}

TEST_CASE("full length: gateway killed" * doctest::skip()) {
  // At period 500 shark's gateway gets SIGKILL and is started again.
  Run run;
  const std::int64_t at = run.come_to(500);
  run.labs.gateway("shark").kill();
  run.wait(2s);
  const std::int64_t still = run.labs.period("shark");
  CHECK(still <= at + 5);
  run.labs.start_gateway("shark");
  run.check();
  run.tell(fmt::format("killed at period {}, at {} two seconds later", at, still));
}

TEST_CASE("full length: both gateways killed" * doctest::skip()) {
  // The labs share nothing but their gateways: without them both stop, at most one period apart (slack 0).
  Run run;
  const std::int64_t at = run.come_to(300);
  run.labs.gateway("shark").kill();
  run.labs.gateway("roark").kill();
  run.wait(3s);
  const std::int64_t shark = run.labs.period("shark"), roark = run.labs.period("roark");
  CHECK(std::abs(shark - roark) <= 1);
  run.wait(2s);
  CHECK(run.labs.period("shark") == shark);
  run.labs.start_gateway("shark");
  run.labs.start_gateway("roark");
  run.check();
  run.tell(fmt::format("killed at period {}, stopped at {} and {}", at, shark, roark));
}

TEST_CASE("full length: lab killed" * doctest::skip()) {
  // At period 500 lab roark gets SIGKILL: shark ends within 10 s, naming it.
  Run run;
  const std::int64_t at = run.come_to(500);
  const auto killed = std::chrono::steady_clock::now();
  run.labs.lab("roark").kill();
  const bool ended = run.labs.lab("shark").wait(20s) == 1;
  CAPTURE(run.labs.lab_output("shark"));
  CAPTURE(run.labs.gateway_output("shark"));
  REQUIRE(ended);
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - killed).count();
  CHECK(took_s < 10);
  CHECK(run.labs.result("shark", "ended").find("roark is gone") != std::string::npos);
  MESSAGE(fmt::format("killed at period {}; {:.1f} s later: {}", at, took_s, run.labs.result("shark", "ended")));
}
