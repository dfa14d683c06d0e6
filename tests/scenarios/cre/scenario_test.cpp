// CRE as a whole, in labs without arenas: what is sensed, heard, harvested, published and told, whatever labs are
// called.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "lab/testing/lab_double.hpp"
#include "scenarios/cre/controller/cre_messages.h"
#include "scenarios/cre/cre.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using hal::Led;
using lab::LabDouble, lab::WorldDouble;
namespace cre = scenarios::cre;

namespace {

// A world of one ground lab and one flying lab, and what a test asks of them.
class CreWorld {
 public:
  explicit CreWorld(std::string ground = "meadow", std::string flying = "sky", hal::Projection ground_is = {},
                    const std::function<void(cre::Settings&)>& change = {})
      : ground_(std::move(ground)), flying_(std::move(flying)), world_(members(ground_is), "meadow") {
    settings_.roles = {.ground = ground_, .flying = flying_};
    if (change) change(settings_);
    world_.begin([&](const std::string&) { return std::make_unique<cre::Cre>(settings_); });
  }
  LabDouble& ground() { return world_[ground_]; }
  LabDouble& flying() { return world_[flying_]; }
  WorldDouble& world() { return world_; }
  const cre::Settings& settings() const { return settings_; }
  const std::vector<std::int64_t>& active() { return flying().lab.field(ground_, "active"); }
  std::vector<hal::Pose> places() const { return cre::places_on_grid(10, 2, 2); }

  // A frame of one lab, `later` than the last boundary.
  void show(LabDouble& lab, hal::LabTime later, std::vector<hal::Observation> robots) {
    lab.frame({.stamp = world_.now() + later, .number = 1, .robots = std::move(robots)});
  }
  // In the flying arena, above a place of the ground.
  hal::Pose above(const hal::Pose& in_ground) {
    return flying().lab.projection().to_arena(ground().lab.projection().to_shared(in_ground));
  }
  // What ground robot `robot` at `in_ground` is told to have heard, `later` than the last boundary.
  std::optional<hal::ToRobot> heard(hal::LabTime later, hal::RobotId robot, const hal::Pose& in_ground,
                                    Led led = Led::off) {
    ground().said.clear();
    show(ground(), later, {{.robot = robot, .pose = in_ground, .led = led}});
    std::optional<hal::ToRobot> told;
    for (const hal::ToRobot& message : ground().said)
      if (message.slot == CRE_HEARD_SLOT) told = message;
    return told;
  }
  // Flying robots above the ground, as all labs know them after a boundary.
  void fly(const std::vector<std::pair<hal::Pose, Led>>& robots) {
    std::vector<hal::Observation> seen;
    for (const auto& [in_ground, led] : robots)
      seen.push_back({.robot = static_cast<hal::RobotId>(seen.size()), .pose = above(in_ground), .led = led});
    show(flying(), 1900ms, seen);
    world_.boundary();
  }

 private:
  std::vector<WorldDouble::Member> members(const hal::Projection& ground_is) const {
    const hal::Projection over{.shift_x_m = ground_is.shift_x_m,
                               .shift_y_m = ground_is.shift_y_m,
                               .turn_rad = 0.3,
                               .scale = 4 * ground_is.scale};
    std::vector<WorldDouble::Member> both = {{ground_, 2.0, ground_is}, {flying_, 0.5, over}};
    if (flying_ < ground_) std::swap(both[0], both[1]);
    return both;
  }

  std::string ground_, flying_;
  cre::Settings settings_;
  WorldDouble world_;
};

std::int64_t sum(const std::vector<std::int64_t>& values, std::size_t from, std::size_t to) {
  return std::accumulate(values.begin() + static_cast<std::ptrdiff_t>(from),
                         values.begin() + static_cast<std::ptrdiff_t>(to), std::int64_t{0});
}

}  // namespace

TEST_CASE("cre: resources belong to the ground lab, whatever it is called") {
  // Only the lab with role ground publishes resources; both labs know them, and each region has its number.
  for (const auto& roles : {std::pair{"meadow", "sky"}, {"sky", "meadow"}, {"zoo", "a"}, {"a", "zoo"}}) {
    const char *const ground = roles.first, *const flying = roles.second;
    CreWorld world(ground, flying);
    CAPTURE(ground);
    CHECK(world.ground().lab.state(flying).fields.count("active") == 0);
    const auto& active = world.active();
    REQUIRE(active.size() == 100);
    CHECK(sum(active, 0, 50) == 10);
    CHECK(sum(active, 50, 100) == 35);
    // Ground robots harvest; flying robots get readings.
    std::size_t at = 50;
    while (active[at] == 0) ++at;
    world.show(world.ground(), 100ms, {{.robot = 0, .pose = world.places()[at]}});
    world.show(world.flying(), 100ms, {{.robot = 0, .pose = {}}});
    CHECK(world.flying().said.size() == 1);
    world.world().boundary();
    CHECK(world.active()[at] == 0);
    CHECK(world.flying().lab.counts()["harvested.south"] == 1);
  }
}

TEST_CASE("cre: a harvest keeps the totals and is seen at the next boundary") {
  // A robot within the radius harvests at once, one beyond does not; the other lab learns of it when states are merged.
  CreWorld world;
  const auto before = world.active();
  std::size_t at = 0;
  while (before[at] == 0) ++at;
  hal::Pose place = world.places()[at];
  place.x_m += 0.0201;
  world.show(world.ground(), 100ms, {{.robot = 0, .pose = place}});
  world.world().boundary();
  CHECK(world.active() == before);
  place.x_m -= 0.0002;
  world.show(world.ground(), 100ms, {{.robot = 0, .pose = place}});
  CHECK(world.active() == before);
  world.world().boundary();
  CHECK(world.active() != before);
  CHECK(world.active()[at] == 0);
  CHECK(sum(world.active(), 0, 50) == 10);
  CHECK(sum(world.active(), 50, 100) == 35);
  for (LabDouble& lab : world.world().labs()) {
    CHECK(lab.lab.counts()["harvested.north"] == 1);
    CHECK(lab.lab.counts()["harvested.south"] == 0);
  }
}

TEST_CASE("cre: flying robots sense both regions through their projection") {
  // Each robot gets the densities within 0.08 m of its own arena, which are 0.32 m of the ground, all robots in one
  // frame and once a second.
  for (const hal::Projection& ground :
       {hal::Projection{}, {.shift_x_m = 3, .shift_y_m = -1, .turn_rad = 2, .scale = 0.5}}) {
    CreWorld world("meadow", "sky", ground);
    hal::RandomStream random(1, "test");
    std::vector<hal::Pose> at;
    std::vector<hal::Observation> robots;
    for (hal::RobotId id = 0; id < 40; ++id) {
      // Not where rounding could decide.
      hal::Pose in_ground;
      bool clear = false;
      while (!clear) {
        in_ground = {.x_m = random.uniform(-0.7, 0.7), .y_m = random.uniform(-0.7, 0.7)};
        clear = true;
        for (const hal::Pose& place : world.places())
          clear &= std::abs(std::hypot(place.x_m - in_ground.x_m, place.y_m - in_ground.y_m) - 0.32) > 1e-6;
      }
      at.push_back(in_ground);
      robots.push_back({.robot = id, .pose = world.above(in_ground)});
    }
    world.show(world.flying(), 100ms, robots);
    REQUIRE(world.flying().said.size() == 40);
    for (hal::RobotId id = 0; id < 40; ++id) {
      const hal::ToRobot expected =
          cre::reading(id, cre::look(at[id], 0.32, world.places(), world.active()), world.flying().said[id].kind);
      CHECK(world.flying().said[id].robot == id);
      CHECK(world.flying().said[id].value == expected.value);
    }
    // The next reading is a second later.
    world.flying().said.clear();
    for (int tenths = 2; tenths <= 10; ++tenths) world.show(world.flying(), tenths * 100ms, robots);
    CHECK(world.flying().said.empty());
    world.show(world.flying(), 1100ms, robots);
    CHECK(world.flying().said.size() == 40);
  }
}

TEST_CASE("cre: flying robots are told of walls with their readings") {
  CreWorld world;
  world.show(world.flying(), 100ms,
             {{.robot = 0, .pose = {}}, {.robot = 1, .pose = {0.2, 0, 0}}, {.robot = 2, .pose = {0.2, 0, 0.6}}});
  REQUIRE(world.flying().said.size() == 3);
  CHECK(world.flying().said[0].kind == CRE_NO_WALL);
  CHECK(world.flying().said[1].kind == CRE_WALL_AHEAD);
  CHECK(world.flying().said[2].kind == CRE_WALL_RIGHT);
}

TEST_CASE("cre: ground robots hear committed flying robots outside their region") {
  // Within 0.20 m of the projected position: red over the south sends north, blue over the north sends south, with the
  // robot's heading; others are not heard.
  for (const hal::Projection& ground :
       {hal::Projection{}, {.shift_x_m = 3, .shift_y_m = -1, .turn_rad = 2, .scale = 0.5}}) {
    CreWorld world("meadow", "sky", ground);
    world.fly({{{.x_m = 0.5, .y_m = 0.5}, Led::blue},
               {{.x_m = -0.5, .y_m = -0.5}, Led::red},
               {{.x_m = 0.5, .y_m = -0.5}, Led::blue},
               {{.x_m = -0.5, .y_m = 0.5}, Led::off}});
    const auto south = world.heard(100ms, 0, {0.5, 0.31, std::numbers::pi / 2});
    REQUIRE(south);
    CHECK(south->robot == 0);
    CHECK(south->kind == CRE_HEARD_SOUTH);
    CHECK(south->value == CRE_TURN / 4);
    const auto north = world.heard(100ms, 1, {-0.5, -0.69, 0});
    REQUIRE(north);
    CHECK(north->kind == CRE_HEARD_NORTH);
    CHECK(north->value == 0);
    CHECK(!world.heard(100ms, 2, {0.5, 0.29, 0}));             // too far
    CHECK(!world.heard(100ms, 3, {0.5, -0.5, 0}));             // in its region
    CHECK(!world.heard(100ms, 4, {-0.5, 0.5, 0}));             // uncommitted
    CHECK(!world.heard(100ms, 5, {0.5, 0.31, 0}, Led::blue));  // it obeys already
    CHECK(world.heard(100ms, 6, {0.5, 0.31, 0}));
  }
}

TEST_CASE("cre: of two flying robots the nearer one is heard") {
  CreWorld world;
  world.fly({{{.x_m = 0, .y_m = 0.05}, Led::blue}, {{.x_m = 0, .y_m = -0.05}, Led::red}});
  CHECK(world.heard(100ms, 0, {0, 0.01, 0})->kind == CRE_HEARD_SOUTH);
  CHECK(world.heard(100ms, 1, {0, -0.01, 0})->kind == CRE_HEARD_NORTH);
}

TEST_CASE("cre: a flying lab that is cut off is not heard") {
  // Its robots have long moved on: they are heard until the next boundary, and again when it is back.
  CreWorld world;
  world.fly({{{.x_m = 0, .y_m = 0.5}, Led::blue}});
  CHECK(world.heard(100ms, 0, {0, 0.5, 0}));
  world.world().boundary({"sky"});
  CHECK(!world.heard(100ms, 1, {0, 0.5, 0}));
  world.fly({{{.x_m = 0, .y_m = 0.5}, Led::blue}});
  CHECK(world.heard(100ms, 2, {0, 0.5, 0}));
}

TEST_CASE("cre: robots are sent what they do") {
  // All robots of both labs, at the start and every ten seconds.
  CreWorld world("meadow", "sky", {}, [](cre::Settings& s) { s.abandon = 0.02; });
  for (LabDouble& lab : world.world().labs()) {
    for (int tenths = 1; tenths <= 200; ++tenths) world.show(lab, tenths * 100ms, {});
    REQUIRE(lab.data.commands.size() == 2);
    CHECK(lab.data.commands[0].kind == hal::FleetCommand::Kind::broadcast);
    CHECK(lab.data.commands[0].data == cre::rules_of(world.settings()).data);
  }
}

TEST_CASE("cre: nothing is said before labs have met") {
  // Frame 0 comes before the first merge.
  WorldDouble alone({{"meadow", 2.0, {}}, {"sky", 0.5, {.scale = 4}}}, "meadow");
  cre::Settings settings;
  settings.roles = {.ground = "meadow", .flying = "sky"};
  for (LabDouble& lab : alone.labs()) {
    lab.scenario = std::make_unique<cre::Cre>(settings);
    lab.scenario->begin(lab.lab);
    lab.frame({.stamp = 0s, .number = 0, .robots = {{.robot = 0, .pose = {0.9, 0.9, 0}, .led = Led::off}}});
    CHECK(lab.said.empty());
    CHECK(lab.data.commands.empty());
  }
}

TEST_CASE("cre: rows, counts and overlays are those of the merged states") {
  // Every lab writes the same row and the same counts at each boundary, and draws regions and active resources where
  // they are in its own arena.
  CreWorld world;
  std::vector<hal::Observation> ground;
  for (hal::RobotId id = 0; id < 10; ++id)
    ground.push_back({.robot = id, .pose = {.x_m = 0, .y_m = id < 7 ? -0.5 : 0.1}});
  world.show(world.ground(), 1900ms, ground);
  std::vector<std::pair<hal::Pose, Led>> flying(20, {{.x_m = 0.5, .y_m = 0.5}, Led::blue});
  flying[0].second = Led::red;
  flying[1].second = Led::off;
  world.fly(flying);
  for (LabDouble& lab : world.world().labs()) {
    REQUIRE(lab.rows().size() == 2);
    CHECK(lab.rows()[1].table == "swarms");
    CHECK(lab.rows()[1].values == "1,2.0,1,1,18,10,7,0,0,7,0,0,3,0,0,0,0,0,0");
    const auto columns = [](const std::string& row) { return std::count(row.begin(), row.end(), ','); };
    CHECK(columns(lab.rows()[1].header) == columns(lab.rows()[1].values));
    CHECK(lab.lab.counts()["consensus.ms"] == 2000);
    CHECK(lab.lab.counts()["consensus.south"] == 1);
    CHECK(lab.lab.counts()["ground.middle_peak_ppm"] == 300'000);
    // Two regions, the border, 100 places of which 45 hold a resource.
    const hal::Drawing& drawing = lab.drawing();
    REQUIRE(drawing.polygons().size() == 2);
    CHECK(drawing.polygons()[0].label == "north: 10 resources");
    CHECK(drawing.polygons()[0].colour == hal::Colour::region_poor);
    CHECK(drawing.polygons()[1].label == "south: 35 resources");
    CHECK(drawing.polygons()[1].colour == hal::Colour::region_rich);
    REQUIRE(drawing.lines().size() == 1);
    REQUIRE(drawing.circles().size() == 100);
    int filled = 0;
    for (const hal::Circle& place : drawing.circles()) {
      filled += place.filled;
      CHECK(place.filled == (place.colour == hal::Colour::resource));
      CHECK(place.dashed == !place.filled);
    }
    CHECK(filled == 45);
    CHECK(lab.lab.counts()["overlay.refused.too_many"] == 0);
  }
  CHECK(world.ground().lab.counts().all() == world.flying().lab.counts().all());
  // The first resource is drawn at its place: on the ground as it is, in the flying arena at a quarter of the size.
  std::size_t first = 0;
  while (world.active()[first] == 0) ++first;
  const hal::Circle& on_ground = world.ground().drawing().circles()[first];
  const hal::Circle& in_air = world.flying().drawing().circles()[first];
  CHECK(on_ground.at.x_m == doctest::Approx(world.places()[first].x_m));
  CHECK(on_ground.at.y_m == doctest::Approx(world.places()[first].y_m));
  CHECK(on_ground.radius_m == doctest::Approx(0.02));
  CHECK(in_air.at.x_m == doctest::Approx(world.above(world.places()[first]).x_m));
  CHECK(in_air.radius_m == doctest::Approx(0.005));
  // The regions are the halves of the ground arena, and the border lies between them.
  const double side_m = 2;
  const hal::Polygon& north = world.ground().drawing().polygons()[0];
  REQUIRE(north.corners.size() == 4);
  for (const hal::Point& corner : north.corners) {
    CHECK(std::abs(corner.x_m) == doctest::Approx(side_m / 2));
    CHECK((std::abs(corner.y_m) < 1e-9 || corner.y_m == doctest::Approx(side_m / 2)));
  }
  for (const hal::Point& end : world.flying().drawing().lines()[0].points)
    CHECK(std::hypot(end.x_m, end.y_m) == doctest::Approx(side_m / 8));
}
