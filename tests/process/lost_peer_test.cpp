// Labs that keep real time and one of them is killed: the others notice, say so, and do as they are configured.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "arkmesh/fleet_command_t.hpp"
#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/shared_view_t.hpp"
#include "hal/bus/bus.hpp"
#include "tests/support/labs/lab_processes.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using tests::LabProcesses;

namespace {

// What a lab tells on its bus: what it is doing, what it says to its robots, and how old its peers' states are.
class LostPeerWatch {
 public:
  explicit LostPeerWatch(const std::string& url) : bus_(url) {
    subscriptions_.push_back(bus_.subscribe("status", [this](std::string_view, auto bytes) {
      if (lab_status_t m; hal::decode(bytes, m)) state = m.state;
    }));
    subscriptions_.push_back(bus_.subscribe("fleet_command", [this](std::string_view, auto bytes) {
      if (fleet_command_t m; hal::decode(bytes, m)) commands.push_back(m.command);
    }));
    subscriptions_.push_back(bus_.subscribe("shared", [this](std::string_view, auto bytes) {
      if (shared_view_t m; hal::decode(bytes, m)) view = m;
    }));
  }
  std::int32_t age(const std::string& lab) const {
    const auto it = std::ranges::find(view.labs, lab, &lab_view_t::lab);
    return it == view.labs.end() ? -1 : it->age_periods;
  }
  bool comes_to(const std::function<bool()>& condition) {
    return tests::eventually(300s, [&] { return bus_.drain(20ms), condition(); });
  }

  std::string state;
  std::vector<int> commands;
  shared_view_t view;

 private:
  hal::Bus bus_;
  std::vector<std::unique_ptr<hal::Bus::Subscription>> subscriptions_;
};

}  // namespace

TEST_CASE("a killed peer of labs in real time pauses, is gone without or ends them, and may be started again") {
  // Shark pauses, roark goes on, and lynx, when it has been started again and roark is killed, ends. On a busy machine
  // a state may come a period or two late all the time.
  LabProcesses labs({.labs = {"shark", "roark", "lynx"},
                     .overrides = {"arena.use=null", "arena.pace=1.0", "gate.period_s=0.5"},
                     .by_lab = {{"roark", {"gate.on_peer_lost=\"go_on\""}}, {"lynx", {"gate.on_peer_lost=\"end\""}}}});
  constexpr int run = fleet_command_t::run, pause = fleet_command_t::pause;
  LostPeerWatch shark(labs.bus_url("shark"));
  labs.start();
  const auto runs_with_lynx = [&] {
    return shark.state == "running" && shark.age("lynx") >= 0 && shark.age("lynx") <= 2;
  };
  REQUIRE_MESSAGE(shark.comes_to(runs_with_lynx), shark.state);
  CHECK(shark.commands == std::vector{run});

  labs.lab("lynx").kill();
  REQUIRE_MESSAGE(shark.comes_to([&] { return shark.state.starts_with("paused without lynx: silent for "); }),
                  shark.state);
  CHECK(shark.commands == std::vector{run, pause});
  CHECK(shark.age("lynx") > 5);
  const auto says = [&](const std::string& lab, const std::string& words) {
    return shark.comes_to([&] { return labs.lab_output(lab).find(words) != std::string::npos; });
  };
  CHECK(says("shark", "shark has lost lynx at period "));
  CHECK(says("shark", "robots pause until it is back, for 600 s at most; restart lynx or repair the link"));
  CHECK(says("roark", "robots continue with its last state; restart lynx or repair the link"));

  labs.start_lab("lynx");
  REQUIRE_MESSAGE(shark.comes_to(runs_with_lynx), shark.state);
  CHECK(shark.commands == std::vector{run, pause, run});
  CHECK(says("shark", "lynx was restarted at period "));
  CHECK(labs.lab("roark").running());

  labs.lab("roark").kill();
  CHECK(labs.lab("lynx").wait(300s) == 1);
  CHECK(labs.result("lynx", "ended").find("lynx has lost roark at period ") == 0);
  CHECK(labs.lab("shark").running());
}
