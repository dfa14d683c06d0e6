// The physical arena between eyes and a cable that the tests hold, in a time that passes only when the arena waits.
#include "hal/platforms/kilobot/kilobot_arena.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/platforms/kilobot/robot_ids.hpp"
#include "tests/hal/platforms/kilobot/overhead_bench.hpp"
#include "tests/support/kilobot/fake_cable.hpp"
#include "tests/support/kilobot/fake_watch.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using namespace arkmesh::tests;
using namespace std::chrono_literals;
using Kind = hal::FleetCommand::Kind;

namespace {

// Passes when somebody waits, at once; the cable's clock goes with it.
class FakeWall final : public hal::WallTime {
 public:
  explicit FakeWall(std::shared_ptr<FakeCable> cable) : cable_(std::move(cable)) {}
  Moment now() override { return now_; }
  void wait_until(Moment then) override { set(std::max(now_, then)); }
  void pass(std::chrono::microseconds time) { set(now_ + time); }

 private:
  void set(Moment now) { cable_->now = now_ = now; }
  std::shared_ptr<FakeCable> cable_;
  Moment now_ = Moment{} + 1h;
};

hal::Section section(const std::string& keys) {
  return hal::Config::from_text("[arena]\nrobots = 4\n" + keys, "lab.toml").root().section("arena");
}

// Of a table whose wire is the test's.
ArenaSettings settings(const std::string& keys) {
  return read_arena_settings(section(keys), "roark", false);
}

// Wishes that the wait ends, from the moment on that a test says so.
struct Operator final : hal::StopRequest {
  bool stopped() override { return wished && wished(); }
  std::function<bool()> wished;
};

struct Table {
  explicit Table(const std::string& keys = "") : eyes_see(std::make_shared<FakeTable>()) {
    eyes_see->robots = read_robot_ids(section(keys));
    arena = make_kilobot_arena(settings(keys), std::make_unique<FakeWatch>(eyes_see), std::make_unique<FakeWire>(cable),
                               wall);
  }
  void say(hal::RobotId robot) {
    const hal::ToRobot message{robot, 0, 1, 5};
    arena->robots().offer({&message, 1});
  }
  // To the end of frame n.
  void frame(int n) { hal::advance(*arena, n * arena->info().frame_period, stops, wall); }
  std::string failure() {
    try {
      frame(0);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  std::shared_ptr<FakeCable> cable = std::make_shared<FakeCable>();
  std::shared_ptr<FakeTable> eyes_see;
  FakeWall wall{cable};
  Operator stops;
  std::unique_ptr<hal::Arena> arena;
};

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("kilobot arena: what it is") {
  // It says that it cannot wait, and what a composite can carry.
  const Table table;
  const hal::ArenaInfo& info = table.arena->info();
  CHECK(info.platform == "kilobot");
  CHECK(info.name == "roark");
  CHECK_FALSE(info.can_wait);
  CHECK(info.max_robot == 1022);
  CHECK(info.kinds == 16);
  CHECK(info.values == 1024);
  CHECK(info.robots == std::vector<hal::RobotId>{0, 1, 2, 3});
}

TEST_CASE("kilobot arena: names first") {
  // advance_to(0) asks the robots what the eyes want to know and ends when everybody is named; lab time stands still,
  // the eyes' does not.
  Table table("kilobot.again_s = 0");
  table.eyes_see->question = Message{{1}, 120, 0};
  table.eyes_see->named_after_looks = 80;
  table.frame(0);
  CHECK(table.arena->clock().now() == hal::LabTime{0});
  CHECK(table.eyes_see->looks == 80);
  CHECK(std::ranges::is_sorted(table.eyes_see->looked_at));
  CHECK(table.eyes_see->looked_at.front() >= 2500ms);  // not before robots can hear the question
  CHECK(table.eyes_see->looked_at.back() >= 7s);
  const auto frame = table.arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->number == 0);
  CHECK(frame->stamp == hal::LabTime{0});
  CHECK(frame->robots.size() == 4);
  const auto heard = table.cable->take();
  REQUIRE(heard.size() == 2);
  CHECK(heard[0].type() == PacketType::stop);
  CHECK(heard[1].message_type() == 120);

  // the answer is there: silence
  table.eyes_see->question.reset();
  table.frame(5);
  REQUIRE(table.cable->heard.size() == 1);
  CHECK(table.cable->heard[0].type() == PacketType::stop);
}

TEST_CASE("kilobot arena: not ready in time") {
  // When the wait is over the sentence names what is missing: robots by id, pictures, or the overhead controller.
  Table nameless("kilobot.names_within_s = 20");
  nameless.eyes_see->in_doubt = {1, 2, 3};
  const std::string said = nameless.failure();
  CAPTURE(said);
  CHECK(holds(said, "within 20 s: 3 of 4 robots have not been seen and named (1-3)"));

  Table blind("kilobot.names_within_s = 20");
  blind.eyes_see->covered = true;
  CHECK(holds(blind.failure(), "the cameras give no picture"));

  Table mute("kilobot.names_within_s = 20");
  mute.cable->plugged = false;
  CHECK(holds(mute.failure(), "there is no cable"));
}

TEST_CASE("kilobot arena: begins without somebody") {
  // When the wait is over, as many robots as may be missing are counted and left out; one more ends the lab, and so
  // does an operator, at once.
  Table table("kilobot.names_within_s = 20\nkilobot.may_miss = 1");
  table.eyes_see->in_doubt = {2};
  table.frame(0);
  CHECK(table.arena->counters()["robots.missing_at_start"] == 1);
  CHECK(table.arena->poses().latest().has_value());

  Table two("kilobot.names_within_s = 20\nkilobot.may_miss = 1");
  two.eyes_see->in_doubt = {2, 3};
  CHECK(holds(two.failure(), "2 of 4 robots have not been seen and named (2, 3)"));

  Table stopped("kilobot.names_within_s = 20\nkilobot.may_miss = 1");
  stopped.eyes_see->in_doubt = {2};
  const Moment begun = stopped.wall.now();
  stopped.stops.wished = [&] { return stopped.wall.now() - begun > 5s; };
  const std::string said = stopped.failure();
  CHECK(holds(said, "stopped by the operator; waited for the table: 1 of 4 robots"));
  CHECK(stopped.wall.now() - begun < 7s);
}

TEST_CASE("kilobot arena: real time") {
  // Lab time begins with the first later call, however long after frame 0, and each frame is looked at in its moment.
  Table table;
  table.frame(0);
  table.wall.pass(10min);
  const Moment start = table.wall.now();
  table.eyes_see->looked_at.clear();
  table.frame(20);
  CHECK(table.wall.now() - start == 2s);
  REQUIRE(table.eyes_see->looked_at.size() == 20);
  for (std::size_t i = 1; i < 20; ++i) CHECK(table.eyes_see->looked_at[i] - table.eyes_see->looked_at[i - 1] == 100ms);
  const auto frame = table.arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->number == 20);
  CHECK(frame->stamp == 2s);
  CHECK(table.arena->counters()["poses.skipped"] == 20);
  CHECK(table.arena->counters()["arena.late"] == 0);
  table.wall.pass(1s);
  table.frame(21);
  CHECK(table.arena->counters()["arena.late"] == 1);
}

TEST_CASE("kilobot arena: nothing blocks") {
  // Every call returns before any time has passed; what is waited for can be read meanwhile, and lab time stands still.
  Table table("kilobot.names_within_s = 20");
  table.eyes_see->in_doubt = {1};
  const Moment begun = table.wall.now();
  CHECK(table.arena->waiting_for().empty());
  CHECK_FALSE(table.arena->advance_to(0us));
  CHECK(holds(table.arena->waiting_for(), "the table: the overhead controller is starting"));
  CHECK(table.wall.now() == begun);
  while (table.wall.now() - begun < 5s) {
    CHECK_FALSE(table.arena->advance_to(0us));
    CHECK(table.arena->next_service() > table.wall.now());
    CHECK(table.arena->next_service() <= table.wall.now() + 20ms);
    table.wall.wait_until(table.arena->next_service());
  }
  CHECK(holds(table.arena->waiting_for(), "the table: 1 of 4 robots"));
  CHECK_FALSE(table.arena->poses().latest());
  table.eyes_see->in_doubt.clear();
  table.frame(0);
  CHECK(table.arena->waiting_for().empty());
  CHECK_FALSE(table.arena->advance_to(100ms));
  CHECK(table.arena->clock().now() == 0us);
}

TEST_CASE("kilobot arena: while a lab waits") {
  // Before lab time begins the eyes are kept open and the controller is served, and no lab time passes.
  Table table("kilobot.again_s = 0");
  table.frame(0);
  REQUIRE(table.arena->poses().latest());
  const int looks = table.eyes_see->looks;
  table.cable->take();
  table.arena->robots().command({Kind::run});
  for (const Moment end = table.wall.now() + 3s; table.wall.now() < end; table.wall.pass(10ms)) table.arena->serve();
  CHECK(table.eyes_see->looks == looks + 29);
  CHECK(table.arena->clock().now() == 0us);
  CHECK_FALSE(table.arena->poses().latest());
  const auto heard = table.cable->take();
  REQUIRE(heard.size() == 2);
  CHECK(heard[0].message_type() == type_run);
  CHECK(heard[1].type() == PacketType::stop);
  table.frame(1);
  CHECK(table.arena->poses().latest()->number == 1);
}

TEST_CASE("kilobot arena: camera gone and back") {
  // Without pictures there are no frames, which is counted, and their numbers stay free; with pictures it goes on.
  Table table;
  table.frame(0);
  REQUIRE(table.arena->poses().latest());
  table.eyes_see->covered = true;
  for (int n = 1; n <= 30; ++n) {
    table.frame(n);
    CHECK_FALSE(table.arena->poses().latest());
  }
  CHECK(table.arena->counters()["poses.lost.no_picture"] == 30);
  CHECK(table.arena->counters()["camera.gone"] == 30);
  table.eyes_see->covered = false;
  table.frame(31);
  const auto frame = table.arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->number == 31);
  CHECK(frame->stamp == 3100ms);
}

TEST_CASE("kilobot arena: what eyes must not invent") {
  // Robots that nobody expects and places off the table are left out and counted; a little over the edge is the edge.
  Table table;
  table.eyes_see->robots = {0, 1, 7};
  table.eyes_see->x_m = 0.51;
  table.frame(0);
  auto frame = table.arena->poses().latest();
  REQUIRE(frame);
  REQUIRE(frame->robots.size() == 2);
  CHECK(frame->robots[0].pose.x_m == 0.5);
  CHECK(table.arena->counters()["poses.refused.unknown_robot"] == 1);
  table.eyes_see->x_m = 0.6;
  table.frame(1);
  frame = table.arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->robots.empty());
  CHECK(table.arena->counters()["poses.refused.outside"] == 2);
}

TEST_CASE("kilobot arena: swapped robots") {
  // From the look that finds two robots in doubt until they are named again nothing is said to them, and the others
  // hear as ever.
  Table table;
  table.frame(0);
  int asked = 0, said = 0;
  for (int n = 1; n <= 60; ++n) {
    if (n == 20) table.eyes_see->in_doubt = {1, 2}, table.eyes_see->question = Message{{}, 119, 0};
    if (n == 40) table.eyes_see->in_doubt.clear(), table.eyes_see->question.reset();
    for (hal::RobotId robot = 0; robot < 4; ++robot) table.say(robot);
    table.cable->take();
    table.frame(n);
    int to_doubtful = 0, to_others = 0, questions = 0;
    for (const auto& one : table.cable->heard) {
      questions += one.message_type() == 119;
      for (const hal::RobotId robot : robots_of(one.packet)) ++(robot == 1 || robot == 2 ? to_doubtful : to_others);
    }
    CAPTURE(n);
    if (n > 20 && n <= 40) CHECK(to_doubtful == 0);
    if (n > 42) CHECK(to_doubtful > 0);
    if (n > 42) CHECK(questions == 0);
    // meanwhile questions and the others take turns
    if (n > 20 && n <= 40)
      asked += questions, said += to_others;
    else
      CHECK(to_others > 0);
  }
  CHECK(asked >= 16);
  CHECK(said >= 2 * 16);
  CHECK(table.arena->counters()["to_robots.withheld.doubtful"] >= 38);
}

TEST_CASE("kilobot arena: overhead controller gone and back") {
  // Frames go on while the controller is gone; old commands expire, newer ones are sent when it is back.
  Table table("kilobot.again_s = 0");
  table.frame(0);
  table.cable->plugged = false;
  table.arena->robots().command({Kind::run});
  for (int n = 1; n <= 80; ++n) {
    table.frame(n);
    CHECK(table.arena->poses().latest());
  }
  CHECK(table.arena->counters()["fleet_command.expired"] == 1);
  CHECK(table.arena->counters()["overhead.line_lost"] == 1);
  table.cable->plugged = true;
  table.cable->take();
  table.arena->robots().command({Kind::voltage});
  table.frame(150);
  const auto heard = table.cable->take();
  REQUIRE(heard.size() == 3);
  CHECK(heard[1].message_type() == type_voltage);
  CHECK(heard[2].type() == PacketType::stop);
}

TEST_CASE("kilobot arena: the last word") {
  // An arena that ends still says its last fleet command and then tells the controller to stop, which would otherwise
  // repeat it for ever; a command for robots asleep is not waited for. So it is whether somebody asks it to end or
  // takes it away.
  for (const auto& [asleep, asked] : {std::pair(false, false), {true, false}, {false, true}, {true, true}}) {
    CAPTURE(asleep);
    CAPTURE(asked);
    Table table("kilobot.again_s = 0");
    table.frame(0);
    if (asleep) table.arena->robots().command({Kind::sleep});
    table.frame(10);
    table.cable->take();
    table.say(1);
    table.arena->robots().command({Kind::pause});
    const Moment end = table.wall.now();
    if (asked) hal::end(*table.arena, table.wall);
    const Moment ended = table.wall.now();
    table.arena.reset();
    if (asked) CHECK(table.wall.now() == ended);
    REQUIRE(table.cable->heard.size() == 2);
    CHECK(table.cable->heard[0].message_type() == type_wakeup);
    CHECK(table.cable->heard[1].type() == PacketType::stop);
    const auto took = table.cable->heard[1].at - end;
    CHECK(took >= (asleep ? 2000ms : 500ms));
    CHECK(took <= (asleep ? 2100ms : 600ms));
  }
}
