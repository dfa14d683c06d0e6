// DHTF as a whole, in labs without arenas: what is published, merged, counted and told.
#include <doctest/doctest.h>

#include <cmath>
#include <set>

#include "lab/testing/lab_double.hpp"
#include "scenarios/dhtf/controller/dhtf_messages.h"
#include "scenarios/dhtf/dhtf.hpp"

using namespace arkmesh;
using namespace arkmesh::scenarios;
using dhtf::dwelling, dhtf::leaving, dhtf::walking;
using hal::Led;
using lab::LabDouble, lab::WorldDouble;

namespace {

const WorldDouble::Member roark{"roark", 0.5, {.scale = 2}}, shark{"shark", 1.0, {}}, lynx{"lynx", 0.5, {.scale = 2}};

dhtf::Settings settings(dhtf::Types types = dhtf::Types::easy) {
  dhtf::Settings s;
  s.types = types;
  s.requirements = {{"lynx", {1, 2}}, {"roark", {1, 2}}, {"shark", {2, 4}}};
  return s;
}

void begin(WorldDouble& world, const dhtf::Settings& s) {
  world.begin([&](const std::string&) { return std::make_unique<dhtf::Dhtf>(s); });
}

hal::Pose site_in_shared(WorldDouble& world, std::size_t site) {
  const lab::Lab& lab = world.labs().front().lab;
  return {.x_m = static_cast<double>(lab.initial_field(lab.owner(), "site_x_um")[site]) * 1e-6,
          .y_m = static_cast<double>(lab.initial_field(lab.owner(), "site_y_um")[site]) * 1e-6};
}

// `n` robots of a lab at a site, `off_m` shared metres east of its centre, all showing `led`.
hal::PoseFrame at_site(WorldDouble& world, std::string_view lab, std::size_t site, int n, Led led, double off_m = 0) {
  hal::PoseFrame frame{.stamp = world.now() + hal::LabTime(100'000), .number = 1, .robots = {}};
  hal::Pose in_shared = site_in_shared(world, site);
  in_shared.x_m += off_m;
  for (int i = 0; i < n; ++i)
    frame.robots.push_back(
        {.robot = static_cast<hal::RobotId>(i), .pose = world[lab].lab.projection().to_arena(in_shared), .led = led});
  return frame;
}

// What a walking robot is told at a site.
hal::ToRobot told_at(WorldDouble& world, std::string_view lab, std::size_t site) {
  LabDouble& one = world[lab];
  hal::PoseFrame frame = at_site(world, lab, site, 1, walking);
  frame.robots[0].robot = 900;
  one.scenario->on_poses(one.lab,
                         {.stamp = frame.stamp, .number = 0, .robots = {{.robot = 900, .pose = {}, .led = walking}}});
  one.take_said();
  one.said.clear();
  one.frame(frame);
  REQUIRE(one.said.size() == 1);
  const hal::ToRobot told = one.said[0];
  one.said.clear();
  return told;
}

std::vector<std::uint64_t> completed(WorldDouble& world) {
  std::vector<std::uint64_t> counts;
  for (const LabDouble& lab : world.labs()) counts.push_back(lab.lab.counts()["completed"]);
  return counts;
}

}  // namespace

TEST_CASE("dhtf: sites lie at the same shared place in both arenas") {
  // A robot is inside up to the site's radius, 0.08 m of the shared world: 0.08 m in shark, 0.04 m in roark.
  WorldDouble world({roark, shark}, "shark");
  begin(world, settings());
  for (const char* name : {"roark", "shark"}) {
    LabDouble& lab = world[name];
    const double scale = lab.lab.projection().scale;
    for (std::size_t site = 0; site < 8; ++site) {
      const hal::Pose centre = lab.lab.projection().to_arena(site_in_shared(world, site));
      for (double r : {0.0, 0.079, 0.081}) {
        lab.said.clear();
        hal::PoseFrame frame{.stamp = hal::LabTime(100'000), .number = 1, .robots = {}};
        frame.robots.push_back({.robot = static_cast<hal::RobotId>(100 + site * 10 + (r > 0) + (r > 0.08)),
                                .pose = {centre.x_m, centre.y_m + r / scale, 0},
                                .led = walking});
        lab.frame(frame);
        const bool inside = !lab.said.empty() && lab.said[0].kind == DHTF_TASK;
        CHECK(inside == (r < 0.08));
      }
    }
  }
}

TEST_CASE("dhtf: a task is completed when both labs have their teams") {
  // One lab's team alone completes nothing; with both it is in force one boundary after it was judged, once, in both
  // labs.
  WorldDouble world({roark, shark}, "shark");
  begin(world, settings());
  world["shark"].frame(at_site(world, "shark", 2, 2, dwelling));
  world.boundary();
  world.boundary();
  CHECK(completed(world) == std::vector<std::uint64_t>{0, 0});
  CHECK(world["roark"].lab.field("shark", "team")[2] == 2);
  world["roark"].frame(at_site(world, "roark", 2, 1, dwelling));
  world.boundary();
  CHECK(completed(world) == std::vector<std::uint64_t>{0, 0});
  world.boundary();
  CHECK(completed(world) == std::vector<std::uint64_t>{1, 1});
  for (int i = 0; i < 5; ++i) world.boundary();
  CHECK(completed(world) == std::vector<std::uint64_t>{1, 1});
  // Both labs release their robots there, and nowhere else.
  for (const char* lab : {"roark", "shark"}) {
    CHECK(told_at(world, lab, 2).kind == DHTF_CLOSED);
    CHECK(told_at(world, lab, 3).kind == DHTF_TASK);
  }
}

TEST_CASE("dhtf: rows of completed tasks") {
  // Every lab writes the same row: when, where, types and who was there.
  WorldDouble world({roark, shark}, "shark");
  begin(world, settings());
  world["shark"].frame(at_site(world, "shark", 5, 3, dwelling));
  world["roark"].frame(at_site(world, "roark", 5, 1, dwelling));
  world.boundary();
  world.boundary();
  const auto cell = world["shark"].lab.initial_field("shark", "site_cell")[5];
  for (LabDouble& lab : world.labs()) {
    REQUIRE(lab.rows().size() == 1);
    CHECK(lab.rows()[0].table == "completed");
    CHECK(lab.rows()[0].header == "period,time_s,site,cell,active_since_s,hard.roark,hard.shark,team.roark,team.shark");
    CHECK(lab.rows()[0].values == fmt::format("2,4.000000,5,{},0.000000,0,0,1,3", cell));
  }
}

TEST_CASE("dhtf: rows of executions that come at once") {
  // There is one for each, but what an owner makes up does not fill the disk.
  WorldDouble world({roark, shark}, "shark");
  begin(world, settings());
  std::vector<std::int64_t> executed(8, 0);
  for (const auto& [count, rows] : {std::pair{3, 3u}, {1'000'000'000, 103u}}) {
    executed[2] = count;
    world["shark"].lab.publish("executed", executed);
    world.boundary();
    CHECK(world["roark"].rows().size() == rows);
  }
}

TEST_CASE("dhtf: what people see of a site") {
  // Each lab draws every site where it lies in its own arena: its kind, and of each lab who is there and who is needed,
  // as numbers in name order and as dots, the own lab's nearest to the site.
  WorldDouble world({roark, shark}, "shark");
  const dhtf::Settings s = settings();
  begin(world, s);
  world["shark"].frame(at_site(world, "shark", 4, 1, dwelling));
  world.boundary();
  for (const char* name : {"roark", "shark"}) {
    const hal::Drawing& drawing = world[name].drawing();
    const hal::Projection& projection = world[name].lab.projection();
    std::vector<hal::Circle> sites, dots;
    for (const hal::Circle& circle : drawing.circles())
      (circle.colour == hal::Colour::own || circle.colour == hal::Colour::other ? dots : sites).push_back(circle);
    REQUIRE(sites.size() == static_cast<std::size_t>(s.sites));
    const hal::Pose expected = projection.to_arena(site_in_shared(world, 4));
    CHECK(sites[4].at.x_m == doctest::Approx(expected.x_m));
    CHECK(sites[4].at.y_m == doctest::Approx(expected.y_m));
    CHECK(sites[4].radius_m * projection.scale == doctest::Approx(s.site_radius_m));
    CHECK(sites[4].colour == hal::Colour::site_active);
    CHECK(sites[4].filled);
    CHECK_FALSE(sites[4].dashed);
    CHECK(sites[4].label == "easy 0/1 + 1/2");
    CHECK(sites[3].label == "easy 0/1 + 0/2");
    // Three robots are needed at each of the sites; one is there.
    CHECK(dots.size() == 3 * sites.size());
    int there = 0;
    double own_m = 0, other_m = 0;
    for (const hal::Circle& dot : dots) {
      const double from_site_m = std::hypot(dot.at.x_m - expected.x_m, dot.at.y_m - expected.y_m);
      there += dot.filled;
      if (dot.filled) {
        CHECK((dot.colour == hal::Colour::own) == (std::string(name) == "shark"));
        CHECK(from_site_m < 2 * sites[4].radius_m);
      }
      if (from_site_m < 2 * sites[4].radius_m) (dot.colour == hal::Colour::own ? own_m : other_m) = from_site_m;
    }
    CHECK(there == 1);
    CHECK(own_m > sites[4].radius_m);
    CHECK(other_m > own_m);
  }
}

TEST_CASE("dhtf: people see hard sites as such, and how long an idle one is away") {
  // The countdown begins with the time that the site is inactive, and ends when it is back.
  dhtf::Settings hard = settings();
  hard.types = dhtf::Types::hard;
  WorldDouble world({roark, shark}, "shark");
  begin(world, hard);
  CHECK(world["roark"].drawing().circles().back().colour == hal::Colour::site_hard);

  WorldDouble easy({roark, shark}, "shark");
  begin(easy, settings());
  easy["shark"].frame(at_site(easy, "shark", 7, 2, dwelling));
  easy["roark"].frame(at_site(easy, "roark", 7, 1, dwelling));
  std::vector<std::string> labels;
  for (int k = 0; k < 40; ++k) {
    easy.boundary();
    const hal::Circle& site = easy["roark"].drawing().circles().back();
    if (site.colour != hal::Colour::site_idle) continue;
    CHECK(site.dashed);
    CHECK_FALSE(site.filled);
    labels.push_back(site.label);
    for (const char* name : {"roark", "shark"}) easy[name].frame(at_site(easy, name, 7, 0, dwelling));
  }
  REQUIRE(labels.size() == 20);
  CHECK(labels.front() == "back in 40 s");
  CHECK(labels.back() == "back in 2 s");
}

TEST_CASE("dhtf: respawn") {
  // A completed site is inactive for exactly 40 s, 20 periods, in every lab at once, with any slack.
  for (std::uint32_t slack : {0u, 1u, 3u}) {
    WorldDouble world({roark, shark}, "shark", 1, slack);
    begin(world, settings());
    world["shark"].frame(at_site(world, "shark", 0, 2, dwelling));
    world["roark"].frame(at_site(world, "roark", 0, 1, dwelling));
    int inactive = 0;
    for (int k = 0; k < 40; ++k) {
      world.boundary();
      const bool closed = told_at(world, "roark", 0).kind == DHTF_CLOSED;
      CHECK((told_at(world, "shark", 0).kind == DHTF_CLOSED) == closed);
      inactive += closed;
    }
    CHECK(inactive == 20);
    CHECK(completed(world) == std::vector<std::uint64_t>{1, 1});
    CHECK(world["shark"].lab.field("shark", "active") == std::vector<std::int64_t>(8, 1));
  }
}

TEST_CASE("dhtf: robots that stay complete the task again after the respawn only") {
  // A team that never moves executes at most once per respawn, decision and return included: every 22 periods.
  WorldDouble world({roark, shark}, "shark");
  begin(world, settings());
  for (int k = 0; k < 220; ++k) {
    world["shark"].frame(at_site(world, "shark", 0, 2, dwelling));
    world["roark"].frame(at_site(world, "roark", 0, 1, dwelling));
    world.boundary();
  }
  CHECK(completed(world) == std::vector<std::uint64_t>{10, 10});
}

TEST_CASE("dhtf: waiting time by the pair of types") {
  // Walking robots of both labs are told 30, 40 or 60 s, as the types of the site in both labs say.
  WorldDouble world({roark, shark}, "shark", 4);
  begin(world, settings(dhtf::Types::random));
  std::set<std::int64_t> pairs;
  for (std::size_t site = 0; site < 8; ++site) {
    const auto hard = world["roark"].lab.initial_field("shark", "site_hard.roark")[site] +
                      world["roark"].lab.initial_field("shark", "site_hard.shark")[site];
    pairs.insert(hard);
    const int expected = hard == 0 ? 30 : hard == 1 ? 40 : 60;
    CHECK(told_at(world, "roark", site).value == expected);
    CHECK(told_at(world, "shark", site).value == expected);
  }
  CHECK(pairs.size() == 3);
}

TEST_CASE("dhtf: three labs") {
  // The teams of all three labs are needed, and all three see the completion.
  WorldDouble world({lynx, roark, shark}, "shark");
  begin(world, settings());
  world["shark"].frame(at_site(world, "shark", 1, 2, dwelling));
  world["roark"].frame(at_site(world, "roark", 1, 1, dwelling));
  world.boundary();
  world.boundary();
  CHECK(completed(world) == std::vector<std::uint64_t>{0, 0, 0});
  world["lynx"].frame(at_site(world, "lynx", 1, 1, dwelling));
  world.boundary();
  world.boundary();
  CHECK(completed(world) == std::vector<std::uint64_t>{1, 1, 1});
}

TEST_CASE("dhtf: only green robots inside the site are a team") {
  // Robots that show another colour, or none, or stand outside, complete nothing however many they are.
  struct Row {
    Led led;
    double off_m;
    bool completes;
  };
  for (const Row& row :
       {Row{dwelling, 0, true}, Row{Led::off, 0, false}, Row{walking, 0, false}, Row{leaving, 0, false},
        Row{Led::white, 0, false}, Row{dwelling, 0.079, true}, Row{dwelling, 0.081, false}}) {
    WorldDouble world({roark, shark}, "shark");
    begin(world, settings());
    world["shark"].frame(at_site(world, "shark", 0, 40, row.led, row.off_m));
    world["roark"].frame(at_site(world, "roark", 0, 12, row.led, row.off_m));
    for (int k = 0; k < 4; ++k) world.boundary();
    CHECK(completed(world)[0] == (row.completes ? 1u : 0u));
  }
}

TEST_CASE("dhtf: a hard task needs more") {
  // The requirement of the hard type counts in each lab.
  WorldDouble world({roark, shark}, "shark");
  begin(world, settings(dhtf::Types::hard));
  world["shark"].frame(at_site(world, "shark", 0, 4, dwelling));
  world["roark"].frame(at_site(world, "roark", 0, 1, dwelling));
  world.boundary();
  world.boundary();
  CHECK(completed(world) == std::vector<std::uint64_t>{0, 0});
  world["roark"].frame(at_site(world, "roark", 0, 2, dwelling));
  world.boundary();
  world.boundary();
  CHECK(completed(world) == std::vector<std::uint64_t>{1, 1});
}

TEST_CASE("dhtf: the nudge moves one site by what it says") {
  // With nudge_site_m = 0.001 the first site lies 1 mm further east; all else that the owner drew is the same.
  std::map<std::string, std::vector<std::int64_t>> drawn[2];
  for (int nudged = 0; nudged < 2; ++nudged) {
    WorldDouble world({roark, shark}, "shark");
    dhtf::Settings s = settings(dhtf::Types::random);
    s.nudge_site_m = nudged * 0.001;
    begin(world, s);
    for (const char* field : {"site_cell", "site_x_um", "site_y_um", "site_hard.roark", "site_hard.shark"})
      drawn[nudged][field] = world["roark"].lab.initial_field("shark", field);
  }
  drawn[0]["site_x_um"][0] += 1000;
  CHECK(drawn[0] == drawn[1]);
}

TEST_CASE("dhtf: a lab that is cut off executes nothing with its old team") {
  // In free mode a cut lab's last state stays in force; no task is executed with it, however long the cut.
  WorldDouble world({roark, shark}, "shark");
  begin(world, settings());
  world["roark"].frame(at_site(world, "roark", 0, 1, dwelling));
  world.boundary();
  for (int k = 0; k < 50; ++k) {
    world["shark"].frame(at_site(world, "shark", 0, 2, dwelling));
    world.boundary({"roark"});
  }
  CHECK(completed(world) == std::vector<std::uint64_t>{0, 0});
  // Back again, it counts at once.
  world.boundary();
  world.boundary();
  CHECK(completed(world) == std::vector<std::uint64_t>{1, 1});
}

TEST_CASE("dhtf: completions are counted in labs that missed states") {
  // Totals travel with the owner's state: a lab that sees none of it for a minute has the right count afterwards.
  WorldDouble world({roark, shark}, "shark");
  begin(world, settings());
  for (int k = 0; k < 10; ++k) {
    world["shark"].frame(at_site(world, "shark", 0, 2, dwelling));
    world["roark"].frame(at_site(world, "roark", 0, 1, dwelling));
    world.boundary();
  }
  CHECK(completed(world) == std::vector<std::uint64_t>{1, 1});
  // Without the owner's state nothing changes, not even the count of what it decides meanwhile.
  for (int k = 0; k < 30; ++k) world.boundary({"shark"});
  CHECK(completed(world) == std::vector<std::uint64_t>{1, 1});
  CHECK(told_at(world, "roark", 0).kind == DHTF_CLOSED);
  world.boundary();
  CHECK(told_at(world, "roark", 0).kind == DHTF_TASK);
}

TEST_CASE("dhtf: an owner that names no sites") {
  // The others say so in their drops, tell their robots nothing, and go on.
  struct Mute final : lab::Scenario {
    void begin(lab::Lab&) override {}
    void on_poses(lab::Lab&, const hal::PoseFrame&) override {}
    void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}
    void on_period(lab::Lab&) override {}
    bool finished(const lab::Lab&) const override { return false; }
  };
  WorldDouble world({roark, shark}, "shark");
  world.begin([](const std::string& lab) -> std::unique_ptr<lab::Scenario> {
    if (lab == "shark") return std::make_unique<Mute>();
    return std::make_unique<dhtf::Dhtf>(settings());
  });
  world["roark"].frame(
      {.stamp = hal::LabTime(100'000), .number = 1, .robots = {{.robot = 1, .pose = {0.24, 0, 0}, .led = walking}}});
  world.boundary();
  CHECK(world["roark"].said.empty());
  CHECK(world["roark"].lab.counts()["sites.missing"] == 1);
}
