// Pheromone that robots of several labs lay: all labs hold the same.
#include "scenarios/kit/shared_pheromone.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "hal/random.hpp"
#include "lab/testing/lab_double.hpp"

namespace arkmesh::scenarios::kit {
namespace {

const Pheromone::Settings settings{
    .width_m = 2, .height_m = 1, .cell_m = 0.02, .half_life_s = 20, .diffusion_m2_s = 1e-5};

// Every robot lays at each frame.
struct Layers final : lab::Scenario {
  SharedPheromone trail{"trail", settings};

  void begin(lab::Lab& lab) override { trail.begin(lab); }
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override {
    for (const hal::Observation& robot : frame.robots) trail.lay(lab, robot.pose, 0.5);
    trail.tell(lab);
  }
  void on_period(lab::Lab& lab) override { trail.on_period(lab); }
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}
  bool finished(const lab::Lab&) const override { return false; }
};

struct World {
  lab::WorldDouble labs;
  std::map<std::string, Layers*> layers;

  explicit World(std::uint32_t slack = 0)
      : labs({{"a", 1, {.shift_x_m = -0.5}}, {"b", 1, {.shift_x_m = 0.5, .turn_rad = 1.2}}, {"c", 0.5, {.scale = 2}}},
             "a", 1, slack) {
    labs.begin([this](const std::string& lab) {
      auto made = std::make_unique<Layers>();
      layers[lab] = made.get();
      return made;
    });
  }
};

hal::PoseFrame frame_of(int robots, hal::RandomStream& random, double side_m) {
  hal::PoseFrame frame;
  for (int i = 0; i < robots; ++i)
    frame.robots.push_back({static_cast<hal::RobotId>(i),
                            {random.uniform(-side_m / 2, side_m / 2), random.uniform(-side_m / 2, side_m / 2), 0}});
  return frame;
}

}  // namespace

TEST_CASE("kit: labs hold one field, which is what all robots have laid") {
  for (const std::uint32_t slack : {0U, 1U}) {
    World world(slack);
    Pheromone all(settings);
    hal::RandomStream random(1, "test/shared");
    std::vector<std::vector<std::pair<hal::Point, double>>> laid;  // by period
    for (int period = 1; period <= 12; ++period) {
      laid.emplace_back();
      for (int frame = 0; frame < 5; ++frame)
        for (const std::string& name : world.labs.names()) {
          lab::LabDouble& lab = world.labs[name];
          const hal::PoseFrame seen = frame_of(10, random, name == "c" ? 0.5 : 1);
          lab.frame(seen);
          for (const hal::Observation& robot : seen.robots) {
            const hal::Pose at = lab.lab.projection().to_shared(robot.pose);
            laid.back().push_back({{at.x_m, at.y_m}, 0.5});
          }
        }
      world.labs.boundary();
      if (period > static_cast<int>(slack))
        for (const auto& [place, amount] : laid[static_cast<std::size_t>(period - 1) - slack]) all.lay(place, amount);
      all.pass(2);
      const std::vector<double>& held = world.layers["a"]->trail.field().cells();
      CHECK(held == world.layers["b"]->trail.field().cells());
      CHECK(held == world.layers["c"]->trail.field().cells());
      const double sum = std::accumulate(held.begin(), held.end(), 0.0),
                   expected = std::accumulate(all.cells().begin(), all.cells().end(), 0.0);
      CHECK(sum == doctest::Approx(expected).epsilon(1e-9));
      for (std::size_t cell = 0; cell < held.size(); cell += 37)
        CHECK(held[cell] == doctest::Approx(all.cells()[cell]).epsilon(1e-9));
    }
  }
}

TEST_CASE("kit: pheromone of periods that did not come is missing and counted") {
  World world;
  hal::RandomStream random(1, "test/shared");
  for (int period = 1; period <= 4; ++period) {
    for (const std::string& name : world.labs.names()) world.labs[name].frame(frame_of(3, random, 0.5));
    world.labs.boundary(period == 2 || period == 3 ? std::vector<std::string>{"b"} : std::vector<std::string>{});
  }
  for (const std::string& name : world.labs.names()) CHECK(world.labs[name].lab.counts()["kit.trail.missed"] == 2);
}

TEST_CASE("kit: what cannot be laid is counted, and 300 robots of three labs stay below 20 kB a period, told twice") {
  World world;
  lab::LabDouble& lab = world.labs["a"];
  SharedPheromone& trail = world.layers["a"]->trail;
  trail.lay(lab.lab, {0, 0, 0}, 1e9);
  trail.lay(lab.lab, {0, 0, 0}, std::nan(""));
  CHECK(lab.lab.counts()["kit.trail.not_laid"] == 2);
  trail.lay(lab.lab, {9, 9, 0}, 1);  // outside the field lies nothing
  CHECK(lab.lab.counts()["kit.trail.not_laid"] == 2);

  // 100 robots that walk at 1 cm/s for 2 s cross three cells of 1 cm each
  hal::RandomStream random(1, "test/bytes");
  hal::PoseFrame frame = frame_of(100, random, 1);
  for (int i = 0; i < 20; ++i) {
    lab.frame(frame);
    for (hal::Observation& robot : frame.robots) robot.pose.x_m += 0.001;
  }
  const std::size_t told = lab.data.fields.at("kit.trail").size() * sizeof(std::int64_t);
  MESSAGE(told * 3, " bytes of three labs in a period");
  CHECK(2 * 3 * told < 20'000);  // a message to other labs holds the last two states
}

TEST_CASE("kit: what another lab tells of pheromone is laid as far as it makes sense") {
  hal::RandomStream random(1, "test/told");
  int malformed = 0;
  for (int round = 0; round < 300; ++round) {
    World world;
    for (const std::string& name : world.labs.names()) world.labs[name].frame(frame_of(3, random, 0.5));
    std::vector<std::int64_t> told = world.labs["b"].data.fields.at("kit.trail");
    REQUIRE(!told.empty());
    told[random.below(told.size())] ^= std::int64_t{1} << random.below(56);
    if (round % 3 == 0) told.push_back(static_cast<std::int64_t>(random.next() >> 8));
    world.labs["b"].data.fields["kit.trail"] = told;
    world.labs.boundary();
    const std::vector<double>& held = world.layers["a"]->trail.field().cells();
    REQUIRE(held == world.layers["b"]->trail.field().cells());
    REQUIRE(std::ranges::all_of(held, [](double amount) { return amount >= 0 && std::isfinite(amount); }));
    malformed += world.labs["a"].lab.counts()["kit.trail.malformed"] > 0;
  }
  CHECK(malformed > 0);
  CHECK(malformed < 300);
}

}  // namespace arkmesh::scenarios::kit
