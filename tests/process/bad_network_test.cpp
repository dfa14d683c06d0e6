// Bytes of a real link that come otherwise in mid-run. tests/campaign/campaign tries links that are cut, stalled,
// flapping or half open, and frozen gateways.
#include <doctest/doctest.h>

#include <chrono>
#include <map>
#include <memory>
#include <string>

#include "lab/result.hpp"
#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/network/impairment_proxy.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using tests::Impairment;
using tests::ImpairmentProxy;
using tests::LabProcesses;

namespace {

// shark listens on 7921; roark reaches it through the proxy, which holds both labs at about four fifths of a run until
// a test sets an impairment: roark sends some 400 bytes each simulated second.
struct Proxied {
  ImpairmentProxy proxy{7921};
  LabProcesses labs;
  explicit Proxied(const std::string& duration)
      : labs({.overrides = {"run.duration_s=" + duration},
              .through_port = {{{"roark", "shark"}, proxy.port()}},
              .first_port = 7920}) {
    proxy.set({.hold_after = 330 * std::stoul(duration)});
    labs.start();
  }
  void check(const std::string& duration) {
    const bool ended = labs.ended(300s);
    CAPTURE(labs.lab_output("shark"));
    CAPTURE(labs.gateway_output("shark"));
    CAPTURE(labs.gateway_output("roark"));
    REQUIRE(ended);
    static std::map<std::string, std::string> hashes;  // of one process, by duration
    std::string& expected = hashes[duration];
    if (expected.empty())
      expected = lab::hash_text(tests::run_labs({.overrides = {"run.duration_s=" + duration}}).hash);
    CHECK(labs.result("shark", "final_hash") == expected);
    CHECK(labs.result("roark", "final_hash") == expected);
  }
};

}  // namespace

TEST_CASE("slices of one byte in mid-run change nothing") {
  // Proves that nothing depends on how TCP cuts the stream.
  Proxied p("300");
  REQUIRE(p.labs.reached("shark", 30, 300s));
  const auto before = p.proxy.counts();
  p.proxy.set({.slice_bytes = 1});
  const std::int64_t at = p.labs.period("shark");
  REQUIRE(at < 140);
  const bool passed = p.labs.reached("shark", at + 10, 300s);
  const auto after = p.proxy.counts();
  CAPTURE(at);
  CAPTURE(p.labs.period("shark"));
  CAPTURE(after.writes - before.writes);
  REQUIRE(passed);
  p.proxy.set({});  // a write for each byte takes long on a busy machine
  p.check("300");
  // Meanwhile about one write for each byte.
  CHECK(after.writes - before.writes > (after.bytes_to_target - before.bytes_to_target) / 2);
}

TEST_CASE("corrupted bytes in mid-run close sessions, are counted, and change nothing") {
  // Proves that a damaged frame is never taken for a state.
  Proxied p("600");
  REQUIRE(p.labs.reached("shark", 30, 300s));
  p.proxy.set({.corrupt_every = 3000});
  REQUIRE(p.labs.period("shark") < 300);
  REQUIRE(p.labs.reached("shark", 60, 300s));
  p.proxy.set({});
  CHECK(p.proxy.counts().corrupted > 0);
  CHECK(p.proxy.counts().connections > 1);  // sessions were closed and made anew
  p.check("600");
}
