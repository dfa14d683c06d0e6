// Thymios on the emulator: cameras see them by their markers, their nodes answer and drive them, as real ones do.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "emulator/emulator_record.hpp"
#include "hal/arenas/robot_words.hpp"
#include "hal/platforms/aseba/aseba_arena.hpp"
#include "hal/robot/set_point.hpp"
#include "tests/emulator/emulator_builder.hpp"
#include "tests/support/processes/temporary_directory.hpp"
#include "tracker/camera/calibration_file.hpp"
#include "tracker/follow/marker_tracker.hpp"

using namespace arkmesh;
using namespace arkmesh::emulator;

namespace {

const std::string three = "-0.5, 0.1, 0.0, 0.5, -0.3, 2.0, 0.0, 0.5, -1.2";

std::string thymios(const std::string& more) {
  return "[emulator]\nframes_per_s = 10\n" + more +
         "[[emulator.camera]]\nwidth_px = 1000\nheight_px = 1000\nx_m = 0.2\nz_m = 2\nlook_x_m = 0\n"
         "distortion = [-0.08, 0.02, 0.001, -0.001, 0.0]\n[emulator.scene]\nmarker_m = 0.06\nglare = 0.5\n"
         "[arena]\nwidth_m = 1.6\nheight_m = 1.6\nrobots = 3\n[arena.ode]\nrobot = \"thymio\"\nids = [4]\n"
         "start_poses = [" +
         three + "]\n";
}

// An emulator, and the arena of a lab at its camera and nodes, in the emulator's time.
struct MarkedBench {
  const hal::Config config;
  Emulator emulator;
  arkmesh::tests::TemporaryDirectory folder;
  std::unique_ptr<tracker::MarkerTracker> tracker;

  class Time final : public hal::WallTime {
   public:
    explicit Time(Emulator& emulator) : emulator_(emulator) {}
    hal::TimePoint now() override { return hal::TimePoint{} + std::chrono::hours(1) + emulator_.now(); }
    void wait_until(hal::TimePoint then) override {
      const auto wait = std::chrono::ceil<hal::LabTime>(then - now());
      if (wait.count() > 0) emulator_.advance_to(emulator_.now() + wait);
    }

   private:
    Emulator& emulator_;
  } time{emulator};

  class Line final : public hal::kilobot::ByteStream {
   public:
    explicit Line(Emulator& emulator) : emulator_(emulator) {}
    void open() override {}
    State check() override {
      heard_ = emulator_.nodes()->take_said();
      return State::open;
    }
    std::span<const std::uint8_t> heard() const override { return heard_; }
    std::size_t write(std::span<const std::uint8_t> bytes) override {
      for (const auto& message : reader_.read(bytes)) emulator_.nodes()->take(message);
      return bytes.size();
    }
    std::size_t waiting_bytes() override { return 0; }
    const std::string& error() const override { return error_; }

   private:
    Emulator& emulator_;
    hal::aseba::MessageReader reader_;
    std::vector<std::uint8_t> heard_;
    std::string error_;
  };

  // Also judges each pose.
  class JudgedEyes final : public hal::aseba::Eyes {
   public:
    explicit JudgedEyes(MarkedBench& bench) : bench_(bench) {}
    void look(hal::LabTime now) override {
      cv::Mat picture;
      bench_.emulator.picture(0, picture);
      hal::PoseFrame& frame = frame_.emplace();
      frame.robots = bench_.tracker->look(now, {&picture, 1});
      const auto truth = bench_.emulator.truth();
      for (const hal::Observation& robot : frame.robots) {
        const hal::Pose& pose = truth[robot.robot - 4].seen.pose;
        bench_.farthest_m =
            std::max(bench_.farthest_m, std::hypot(robot.pose.x_m - pose.x_m, robot.pose.y_m - pose.y_m));
        bench_.most_turned_rad =
            std::max(bench_.most_turned_rad,
                     std::abs(std::remainder(robot.pose.heading_rad - pose.heading_rad, 6.283185307179586)));
        ++bench_.judged;
      }
    }
    std::optional<hal::PoseFrame> latest() override { return std::exchange(frame_, std::nullopt); }
    const std::vector<hal::RobotId>& missing() const override { return bench_.tracker->missing(); }
    std::string error() const override { return {}; }
    const hal::Counters& counters() const override { return bench_.tracker->counters(); }

   private:
    MarkedBench& bench_;
    std::optional<hal::PoseFrame> frame_;
  };
  double farthest_m = 0, most_turned_rad = 0;
  int judged = 0;
  std::unique_ptr<hal::Arena> arena;  // whose last word needs all of the above
  hal::LabTime now{0};

  explicit MarkedBench(const std::string& more = "exposure_s = 0.004\n")
      : config(hal::Config::from_text(thymios(more), "emulator.toml")), emulator(config.root()) {
    config.refuse_unknown();
    write_calibration(emulator, (folder.path() / "testbed.yaml").string());
    const hal::Config lab = hal::Config::from_text(
        "[arena]\nrobots = 3\nwidth_m = 1.6\nheight_m = 1.6\n[arena.aseba]\nconnect = \"tcp:127.0.0.1:1\"\nfirst_id = "
        "4\n",
        "");
    const auto settings = hal::aseba::read_aseba_settings(lab.root().section("arena"), "lab");
    tracker = std::make_unique<tracker::MarkerTracker>(
        std::vector{tracker::Calibration(tracker::read_calibration(folder.path() / "testbed.yaml").data)},
        tracker::MarkerSettings{
            .side_m = 0.06, .height_m = hal::aseba::kind_of("thymio").height_m, .robots = settings.info.robots});
    std::vector<hal::aseba::Connection> connections;
    connections.push_back({"the line", {}, std::make_unique<Line>(emulator)});
    arena = hal::aseba::make_aseba_arena(settings, std::move(connections), std::make_unique<JudgedEyes>(*this), time);
    hal::advance(*arena, hal::LabTime{0}, hal::nobody_stops(), time);
  }
  void pass(hal::LabTime span) {
    for (const hal::LabTime end = now + span; now < end;)
      hal::advance(*arena, now += ms(100), hal::nobody_stops(), time);
  }
  void command(hal::FleetCommand::Kind kind) { arena->robots().command({.kind = kind}); }
  void drive(hal::RobotId robot, const hal::SetPoint& wheels) {
    const hal::ToRobot word = hal::to_robot(robot, wheels);
    arena->robots().offer({&word, 1});
  }
  hal::Pose pose(hal::RobotId robot) { return emulator.truth()[robot - 4].seen.pose; }
  double moves_m(hal::RobotId robot, hal::LabTime span) {
    const hal::Pose before = pose(robot);
    pass(span);
    return std::hypot(pose(robot).x_m - before.x_m, pose(robot).y_m - before.y_m);
  }
  hal::Led led(hal::RobotId robot) { return arena->poses().latest()->robots[robot - 4].led; }
  using Kind = hal::FleetCommand::Kind;
};

}  // namespace

TEST_CASE("marked robots: seen where they are, driven, stopped") {
  // Each pose of driving robots is within 5 mm of the truth; they stand within 2 s of the word, and drive on after it.
  MarkedBench bench;
  bench.command(MarkedBench::Kind::run);
  bench.drive(4, {100, 60});
  bench.drive(5, {200, 200});
  bench.drive(6, {-60, 60});
  bench.pass(ms(300));
  CHECK(bench.moves_m(5, ms(1'000)) == doctest::Approx(0.2).epsilon(0.05));
  bench.drive(5, {-200, -150});
  bench.pass(ms(3'000));
  CHECK(bench.judged >= 120);
  CHECK(bench.farthest_m < 0.005);
  CHECK(bench.most_turned_rad < 0.05);
  bench.command(MarkedBench::Kind::pause);
  bench.pass(ms(1'000));
  for (const hal::RobotId robot : {4U, 5U, 6U}) CHECK(bench.moves_m(robot, ms(200)) == 0);
  bench.pass(ms(1'000));
  CHECK(hal::in_words(bench.arena->not_standing()).empty());
  bench.command(MarkedBench::Kind::run);
  bench.pass(ms(300));
  CHECK(bench.moves_m(4, ms(500)) > 0.03);
  // a word is its kind's colour
  const hal::ToRobot green{.robot = 4, .kind = 2};
  bench.arena->robots().offer({&green, 1});
  bench.pass(ms(500));
  CHECK(bench.led(4) == hal::Led::green);
}

TEST_CASE("marked robots: proximity") {
  // A robot that drives at a wall says so to its lab, and its node's variable reads as what it said last.
  MarkedBench bench;
  bench.command(MarkedBench::Kind::run);
  bench.drive(4, {200, 200});
  bench.pass(ms(8'000));
  int front = 0;
  for (const hal::FromRobot& said : bench.arena->robots().heard())
    if (said.robot == 4 && bench.arena->info().says.at(said.kind) == "prox.horizontal.2") front = said.value;
  CHECK(front > 4000);
  namespace aseba = hal::aseba;
  bench.emulator.nodes()->take_said();
  constexpr int address = 37;  // of prox.horizontal[2], among the node's variables
  bench.emulator.nodes()->take(aseba::make_message(aseba::get_variables, {4, address, 1}));
  const auto answers = aseba::MessageReader().read(bench.emulator.nodes()->take_said());
  REQUIRE(answers.size() == 1);
  CHECK(std::abs(aseba::words_of(answers[0]).at(1) - front) <= 200);
}

TEST_CASE("marked robots: a long exposure hides markers that move") {
  // At the speed that doctor prints for this exposure a marker is seen, at three times of it it is not.
  constexpr double exposure_s = 0.05;
  MarkedBench bench("exposure_s = 0.05\n");
  const double seen_m_s = tracker::MarkerTracker::largest_speed_m_s({.side_m = 0.06}, exposure_s);
  CHECK(seen_m_s == doctest::Approx(0.15));
  bench.command(MarkedBench::Kind::run);
  bench.drive(5, {60, 60});
  bench.pass(ms(500));
  CHECK(bench.tracker->missing().empty());
  MarkedBench longer("exposure_s = 0.15\n");
  longer.command(MarkedBench::Kind::run);
  longer.drive(5, {150, 150});
  longer.pass(ms(800));
  CHECK(longer.tracker->missing() == std::vector<hal::RobotId>{5});
}

TEST_CASE("marked robots: faults of nodes") {
  // A dead robot's node is lost and said so, and found when it is switched on; garbage is counted, and by it
  // and late answers nobody is lost; robots that hear no lab stand by themselves.
  MarkedBench bench;
  bench.command(MarkedBench::Kind::run);
  for (const hal::RobotId robot : {4U, 5U, 6U}) bench.drive(robot, {60, 40});
  bench.pass(ms(500));
  CHECK(bench.emulator.command("robot 1 kill") == "ok");
  CHECK(bench.moves_m(5, ms(6'000)) < 0.02);
  CHECK(bench.arena->counters()["nodes.lost"] == 1);
  CHECK(bench.emulator.command("robot 1 revive") == "ok");
  bench.pass(ms(2'000));
  CHECK(bench.arena->counters()["nodes.found"] == 4);
  bench.drive(5, {60, 40});
  bench.pass(ms(500));
  CHECK(bench.moves_m(5, ms(500)) > 0.02);
  CHECK(bench.emulator.command("nodes garbage 1000000") == "ok");
  bench.pass(ms(4'000));
  CHECK(bench.arena->counters()["aseba.damaged_bytes"] > 500'000);  // the rest looked like messages
  CHECK(bench.emulator.command("nodes stall 2") == "ok");
  bench.pass(ms(4'000));
  CHECK(bench.arena->counters()["nodes.lost"] == 1);
  CHECK(bench.moves_m(4, ms(500)) > 0.02);
  // nobody speaks: the emulator's time passes without the lab
  bench.emulator.advance_to(bench.emulator.now() + ms(1'700));
  const hal::Pose stood = bench.pose(4);
  bench.emulator.advance_to(bench.emulator.now() + ms(1'000));
  CHECK(bench.pose(4).x_m == stood.x_m);
  bench.pass(ms(4'500));  // of which 2.7 s are past
  CHECK(bench.arena->counters()["robots.stopped_alone"] >= 3);
  CHECK(bench.moves_m(4, ms(500)) > 0.02);
}

TEST_CASE("marked robots: commands of other makes") {
  // What there is not is refused by name.
  MarkedBench bench;
  CHECK(bench.emulator.command("ohc unplug").find("no overhead controller") != std::string::npos);
  CHECK(bench.emulator.command("nodes garbage x").find("needs a number of bytes") != std::string::npos);
  CHECK(bench.emulator.command("nodes fly").find("not a command") != std::string::npos);
  CHECK(bench.emulator.command("say sleep").find("not a command") != std::string::npos);
  CHECK(bench.emulator.command("status").find("ohc=") == std::string::npos);
  Emulator kilobots = TestEmulator{}.make();
  CHECK(kilobots.command("nodes cut").find("Kilobots have no nodes") != std::string::npos);
  const auto config = hal::Config::from_text(
      "[emulator]\n[emulator.scene]\nmarkers = \"apriltag_16h5\"\n[arena]\nrobots = 1\nwidth_m = 1\n[arena.ode]\nrobot "
      "= \"thymio\"\nids = [30]\n",
      "e.toml");
  CHECK_THROWS_WITH_AS(Emulator(config.root()), doctest::Contains("has the numbers 0 to 29, but robot 30"),
                       hal::ConfigError);
}
