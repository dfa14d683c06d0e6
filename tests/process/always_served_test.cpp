// A lab on an emulated testbed, whatever it waits for, says how it is and shows its arena: people see that it lives.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "hal/arenas/messages.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/processes/run_delay.hpp"
#include "tests/support/view/browser.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using tests::LabProcesses;

namespace {

// Watches a lab's page, as soon as the lab has told where it is.
class Viewer {
 public:
  // Messages and pictures that have come so far.
  std::pair<std::size_t, std::size_t> heard(const std::string& told) {
    if (const auto at = told.find("see it at http://127.0.0.1:");
        !browser_ && told.find("#token=", at) != std::string::npos) {
      browser_.emplace([] { ::poll(nullptr, 0, 2); }, static_cast<std::uint16_t>(std::stoi(told.substr(at + 27))));
      CHECK(browser_->join() == 101);
    }
    if (!browser_) return {};
    const auto& all = browser_->messages();
    return {all.size(), std::ranges::count_if(all, [](const auto& one) { return one.kind() == 2; })};
  }

 private:
  std::optional<tests::Browser> browser_;
};

// What came while the lab's state began with some words.
struct Seen {
  std::vector<Clock::time_point> statuses, page;
  std::size_t pictures = 0;
  std::chrono::nanoseconds late{};  // for how long the lab wanted a processor and had none
};

Clock::duration longest_gap(const std::vector<Clock::time_point>& moments) {
  Clock::duration longest{};
  for (std::size_t i = 1; i < moments.size(); ++i) longest = std::max(longest, moments[i] - moments[i - 1]);
  return longest;
}

// Looks until so many statuses of that state, as many messages of the page, and so many pictures of a camera have come.
Seen look(LabProcesses& labs, const std::string& lab, const std::string& state, std::size_t pictures) {
  Seen seen;
  std::string current;
  hal::Bus bus(labs.bus_url(lab));
  const auto status = bus.subscribe(hal::channel::status, [&](std::string_view, std::span<const std::byte> bytes) {
    lab_status_t message;
    REQUIRE(hal::decode(bytes, message));
    current = message.state;
    if (current.starts_with(state)) seen.statuses.push_back(Clock::now());
  });
  Viewer viewer;
  std::size_t before = 0;
  const std::string process = std::to_string(labs.lab(lab).id());
  const auto late = tests::run_delay(process);
  CHECK(tests::eventually(300s, [&] {
    bus.drain(2ms);
    const auto [now, shown] = viewer.heard(labs.lab_output(lab));
    if (now > before && current.starts_with(state)) seen.page.push_back(Clock::now());
    before = now;
    seen.pictures = shown;
    return !labs.lab(lab).running() ||
           (seen.statuses.size() >= 5 && seen.page.size() >= 5 && seen.pictures >= pictures);
  }));
  seen.late = tests::run_delay(process) - late;
  CAPTURE(labs.lab_output(lab));
  CHECK(labs.lab(lab).running());
  return seen;
}

void check_lively(const Seen& seen) {
  CHECK(seen.statuses.size() >= 5);
  CHECK(seen.page.size() >= 5);
  CHECK(longest_gap(seen.statuses) < 8s + seen.late);
  CHECK(longest_gap(seen.page) < 8s + seen.late);
}

}  // namespace

TEST_CASE("a lab that waits for an absent peer serves its page and answers") {
  LabProcesses labs({.overrides = {"arena.use=emulated"}});
  labs.start_lab("roark");
  check_lively(look(labs, "roark", "waiting for shark", 0));
}

TEST_CASE("a lab that identifies its robots shows its arena and answers") {
  // Robot 12 is nowhere, so that the search lasts.
  LabProcesses labs({.overrides = {"arena.use=emulated", "arena.robots=13"}});
  labs.start_lab("roark");
  const Seen seen = look(labs, "roark", "waiting for the testbed", 5);
  check_lively(seen);
  CHECK(seen.pictures >= 5);
}

TEST_CASE("a lab that waits for the next frame of a slow arena answers") {
  // Frames are five seconds apart; the lab says each second how it is nonetheless.
  LabProcesses labs(
      {.labs = {"shark"},
       .overrides = {"arena.use=null", "arena.pace=1.0", "arena.frame_period_s=5.0", "gate.period_s=5.0"}});
  labs.start_lab("shark");
  check_lively(look(labs, "shark", "running", 0));
}
