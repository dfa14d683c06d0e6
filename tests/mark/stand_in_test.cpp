// Ten minutes with scripted originals, in both experiments and both roles: both sides believe the same.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "tests/support/mark/stand_in_run.hpp"
#include "tests/support/processes/thorough.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;

namespace {

constexpr double period_s = 2;

// Moments by site, in seconds of lab time.
using Beliefs = std::map<std::size_t, std::vector<double>>;

Beliefs of_original(StandInRun& run, const ScriptedOriginal& original) {
  Beliefs out;
  for (const ScriptedOriginal::Done& done : original.done) out[done.site].push_back(run.seconds(done.tick));
  return out;
}

// The same tasks in the same order, each a period apart at most. What one side learnt in the last moment may be missing
// on the other.
void check_agree(const Beliefs& theirs, const Beliefs& ours, double until_s) {
  std::size_t both = 0;
  for (std::size_t site = 0; site < 16; ++site) {
    CAPTURE(site);
    const std::vector<double> a = theirs.contains(site) ? theirs.at(site) : std::vector<double>{},
                              b = ours.contains(site) ? ours.at(site) : std::vector<double>{};
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
      if (i >= a.size() || i >= b.size()) {
        CHECK((i < a.size() ? a[i] : b[i]) > until_s - period_s);
        continue;
      }
      ++both;
      CHECK(std::abs(a[i] - b[i]) <= period_s + 1e-9);
    }
  }
  CHECK(both >= 20);  // enough to mean something
}

// What the lab of arkmesh believes, as soon as it does.
Beliefs run_to_the_end(StandInRun& run) {
  Beliefs ours;
  std::vector<std::int64_t> known(8, 0);
  while (run.step()) {
    const lab::Lab& shark = run.lab("shark").lab();
    if (run.lab("shark").period() == 0) continue;
    const auto& executed = shark.field(shark.owner(), "executed");
    for (std::size_t site = 0; site < executed.size(); ++site)
      for (; known[site] < executed[site]; ++known[site])
        ours[site].push_back(1e-6 * static_cast<double>(shark.now().count()));
  }
  for (const std::string& lab : {run.labs().lab(0).name(), run.labs().lab(1).name()}) {
    CAPTURE(lab);
    CHECK(run.lab(lab).reason().empty());
    CHECK(run.lab(lab).finished());
  }
  return ours;
}

const std::vector<NetworkOptions> networks = {{.cuts = false}, {.delay_ticks = 3, .cuts = true}};

}  // namespace

TEST_CASE("dhtf with an original client: ten minutes, and the same tasks are done on both sides" *
          doctest::skip(!arkmesh::tests::thorough())) {
  // Shark, unchanged, owns the sites. Each task that the original believes done is one that shark executed, at the same
  // site, a period apart at most. The original never had a message cut, nor more unread than one read takes.
  for (const NetworkOptions& options : networks) {
    DhtfOriginalClient original(1);
    ScriptedNetwork network{.options = options, .original = &original};
    StandInRun run(mark::Role::server, "dhtf", "shark", network, {"run.duration_s=600", "arena.ode.speed_spread=0"});
    const Beliefs ours = run_to_the_end(run);
    CHECK(original.sites.size() == 8);
    check_agree(of_original(run, original), ours, 600);
    CHECK(original.cut_reads == 0);
    CHECK(original.most_unread <= 30);
    const hal::Counters drops = run.lab("argos").drops();
    for (const auto& [name, total] : drops.all()) CHECK_FALSE(name.starts_with("arena.mark.refused"));
    CHECK(run.lab("argos").lab().counts()["completed"] == run.lab("shark").lab().counts()["completed"]);
    // What it does not say is marked so.
    const auto& unknown = run.lab("shark").lab().initial_field("argos", "lab.unknown");
    CHECK(unknown == std::vector<std::int64_t>{1, 1, 1, 1, 1, 1});
    CHECK(run.lab("shark").lab().state("argos").robots.empty());
    CHECK(run.lab("shark").lab().initial_field("shark", "lab.unknown").empty());
  }
}

TEST_CASE("dhtf with an original server: ten minutes, and the same tasks are done on both sides" *
          doctest::skip(!arkmesh::tests::thorough())) {
  // The original owns the sites and judges; shark plays with its sites and types.
  for (const NetworkOptions& options : networks) {
    DhtfOriginalServer original(2, "Ibcghijko0100101101011100");
    ScriptedNetwork network{.options = options, .original = &original};
    StandInRun run(mark::Role::client, "dhtf", "shark", network, {"run.duration_s=600", "shared.owner=argos"});
    const Beliefs ours = run_to_the_end(run);
    check_agree(of_original(run, original), ours, 600);
    CHECK(original.cut_reads == 0);
    CHECK(original.most_unread <= 30);
    const lab::Lab& shark = run.lab("shark").lab();
    CHECK(shark.initial_field("argos", "site_cell") == std::vector<std::int64_t>{1, 2, 6, 7, 8, 9, 10, 14});
    CHECK(shark.initial_field("argos", "site_hard.argos") == std::vector<std::int64_t>{0, 1, 0, 0, 1, 0, 1, 1});
    CHECK(shark.initial_field("argos", "site_hard.shark") == std::vector<std::int64_t>{0, 1, 0, 1, 1, 1, 0, 0});
    CHECK(shark.initial_field("argos", "site_x_um")[0] == -125'000);
    CHECK(shark.initial_field("argos", "site_y_um")[0] == 375'000);
  }
}

TEST_CASE("cre with an original ground swarm: ten minutes, and its harvest is known" *
          doctest::skip(!arkmesh::tests::thorough())) {
  // Sky flies; the original harvests, and hears committed robots of sky where they are.
  for (const NetworkOptions& options : networks) {
    CreOriginalGround original(3, 10, 35);
    ScriptedNetwork network{.options = options, .original = &original};
    StandInRun run(mark::Role::server, "cre_ground", "sky", network, {"run.duration_s=600"});
    std::vector<std::uint64_t> harvested;
    std::vector<int> active;
    while (run.step()) {
    }
    CHECK(run.labs().finished());
    const lab::Lab& sky = run.lab("sky").lab();
    // As far as it went until the last boundary: a harvest in 3 s in each region.
    const auto& told = sky.field("argos", "harvested");
    for (std::size_t half = 0; half < 2; ++half) {
      std::uint64_t until = 0, since = 0;
      for (const ScriptedOriginal::Done& done : original.done) {
        const double at_s = run.seconds(done.tick);
        until += done.site == half && at_s <= 600 - period_s && at_s > 0;
        since += done.site == half && at_s <= 600 + period_s;
      }
      CHECK(static_cast<std::uint64_t>(told.at(half)) >= until);
      CHECK(static_cast<std::uint64_t>(told.at(half)) <= since);
      CHECK(until > 100);
    }
    CHECK(std::ranges::count(sky.field("argos", "active"), 1) == 45);
    CHECK(original.robots.size() == 100);
    CHECK(original.commands[0] + original.commands[1] > 100);
    CHECK(original.cut_reads == 0);
    CHECK(original.most_unread <= 2000);
    CHECK(sky.state("argos").robots.empty());
  }
}

TEST_CASE("cre with an original flying swarm: ten minutes, and its robots are where they say" *
          doctest::skip(!arkmesh::tests::thorough())) {
  // Meadow harvests; the original flies, and knows which places are active.
  for (const NetworkOptions& options : networks) {
    CreOriginalFlying original(4, 20);
    ScriptedNetwork network{.options = options, .original = &original};
    StandInRun run(mark::Role::client, "cre_flying", "meadow", network, {"run.duration_s=600"});
    // What it hears is what meadow's places were at one of the last boundaries.
    std::deque<std::string> newest;
    int looked = 0, strange = 0;
    while (run.step()) {
      const lab::Runner& meadow_run = run.lab("meadow");
      if (meadow_run.period() == 0) continue;
      std::string places;
      for (const std::int64_t one : meadow_run.lab().field("meadow", "active")) places += one == 1 ? '0' : '1';
      if (newest.empty() || newest.back() != places) newest.push_back(places);
      if (newest.size() > 3) newest.pop_front();
      if (original.resources.empty()) continue;
      ++looked;
      strange += std::ranges::find(newest, original.resources) == newest.end();
    }
    CHECK(run.labs().finished());
    CHECK(looked > 10'000);
    CHECK(strange == 0);
    const lab::Lab& meadow = run.lab("meadow").lab();
    const auto& robots = meadow.state("argos").robots;
    REQUIRE(robots.size() == 20);
    for (std::size_t i = 0; i < robots.size(); ++i) {
      // As its own peer takes it, four times as large; a few centimetres further by now.
      const auto& said = original.robots()[i];
      CHECK(robots[i].in_shared.x_m == doctest::Approx(4 * said.x / 100.0 - 1).epsilon(0.5));
      CHECK(robots[i].in_shared.y_m == doctest::Approx(4 * said.y / 100.0 - 1).epsilon(0.5));
    }
    CHECK(original.cut_reads == 0);
    CHECK(original.most_unread <= 2000);
    CHECK(meadow.initial_field("argos", "lab.unknown") == std::vector<std::int64_t>{0, 1, 1, 0, 1, 1});
  }
}
