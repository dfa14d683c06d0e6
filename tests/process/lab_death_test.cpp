// Ends of labs that tests/campaign/campaign does not try: it kills, stops and hangs them in each phase of a run.
#include <doctest/doctest.h>

#include <chrono>
#include <csignal>
#include <string>

#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/lab_processes.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using tests::LabProcesses;

TEST_CASE("a lab that is started again in mid-run ends the run by name") {
  // Proves rule 6: a strict run never goes on with a lab that has forgotten the past.
  LabProcesses labs({});
  labs.start();
  REQUIRE(labs.reached("roark", 10, 300s));
  labs.lab("roark").kill();
  labs.start_lab("roark");
  REQUIRE(labs.lab("shark").wait(300s) == 1);
  const std::string said = labs.lab_output("shark");
  CAPTURE(said);
  CHECK((said.find("roark was restarted at period") != std::string::npos ||
         said.find("roark is gone at period") != std::string::npos));
}

TEST_CASE("the operator's interrupt ends a lab with its results written") {
  // Proves that neither Ctrl-C nor a closed terminal loses anything, and that a lab whose peer was stopped counts as
  // stopped, too.
  for (const int signal : {SIGINT, SIGHUP}) {
    LabProcesses labs({});
    labs.start();
    REQUIRE(labs.reached("shark", 5, 300s));
    labs.lab("shark").signal(signal);
    CHECK(labs.lab("shark").wait(300s) == 3);
    CHECK(labs.result("shark", "ended") == "stopped by the operator");
    CHECK(labs.result("shark", "state") == "stopped");
    CHECK(labs.lab("roark").wait(300s) == 3);
    CHECK(labs.result("roark", "state") == "stopped");
    CHECK(labs.lab_output("roark").find("shark is gone at period") != std::string::npos);
  }
}

TEST_CASE("a lab whose robots' program crashes leaves its results, and its peers say why it ended") {
  LabProcesses labs(
      {.overrides = {"gate.period_s=0.5"},
       .by_lab = {{"roark", {"arena.ode.controller=\"" ARKMESH_SOURCE_DIR "/tests/programs/crash_null.c\""}}}});
  labs.start();
  CHECK(labs.lab("roark").wait(300s) == 1);
  CHECK(labs.lab("shark").wait(300s) == 1);
  const std::string reason = labs.result("roark", "ended");
  CHECK(reason.starts_with("roark failed at period 3: the program of robot 3 crashed: bad pointer"));
  CHECK(labs.result("roark", "state") == "failed");
  CHECK(labs.result("shark", "ended").starts_with("roark is gone at period 3: failed: roark failed at period 3"));
}
