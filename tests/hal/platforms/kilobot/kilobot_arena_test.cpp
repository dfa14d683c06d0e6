// The physical arena between eyes and a cable that the tests hold, in a time that passes only when the arena waits.
#include "hal/platforms/kilobot/kilobot_arena.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/arenas/robot_words.hpp"
#include "hal/platforms/kilobot/robot_ids.hpp"
#include "tests/hal/platforms/kilobot/overhead_bench.hpp"
#include "tests/support/kilobot/fake_cable.hpp"
#include "tests/support/kilobot/fake_monitor.hpp"

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
  TimePoint now() override { return now_; }
  void wait_until(TimePoint then) override { set(std::max(now_, then)); }
  void pass(std::chrono::microseconds time) { set(now_ + time); }

 private:
  void set(TimePoint now) { cable_->now = now_ = now; }
  std::shared_ptr<FakeCable> cable_;
  TimePoint now_ = TimePoint{} + 1h;
};

hal::Section arena_section(const std::string& keys) {
  return hal::Config::from_text("[arena]\nrobots = 4\n" + keys, "lab.toml").root().section("arena");
}

// Of a testbed whose byte stream is the test's.
ArenaSettings settings(const std::string& keys) {
  return read_arena_settings(arena_section(keys), "roark", false);
}

// Wishes that the wait ends, from the moment on that a test says so.
struct Operator final : hal::StopRequest {
  bool stopped() override { return wished && wished(); }
  std::function<bool()> wished;
};

struct Testbed {
  explicit Testbed(const std::string& keys = "") : eyes_see(std::make_shared<FakeTestbed>()) {
    eyes_see->robots = read_robot_ids(arena_section(keys), ark_layout);
    arena = make_kilobot_arena(settings(keys), std::make_unique<FakeMonitor>(eyes_see),
                               std::make_unique<FakeStream>(cable), nullptr, wall);
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
  std::shared_ptr<FakeTestbed> eyes_see;
  FakeWall wall{cable};
  Operator stops;
  std::unique_ptr<hal::Arena> arena;
};

bool has_part(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("kilobot arena: what it is") {
  // It says that it cannot wait, and what a composite can carry.
  const Testbed testbed;
  const hal::ArenaInfo& info = testbed.arena->info();
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
  Testbed testbed("kilobot.again_s = 0");
  testbed.eyes_see->question = Message{{1}, 120, 0};
  testbed.eyes_see->named_after_looks = 80;
  testbed.frame(0);
  CHECK(testbed.arena->clock().now() == hal::LabTime{0});
  CHECK(testbed.eyes_see->looks == 80);
  CHECK(std::ranges::is_sorted(testbed.eyes_see->looked_at));
  CHECK(testbed.eyes_see->looked_at.front() >= 2500ms);  // not before robots can hear the question
  CHECK(testbed.eyes_see->looked_at.back() >= 7s);
  const auto frame = testbed.arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->number == 0);
  CHECK(frame->stamp == hal::LabTime{0});
  CHECK(frame->robots.size() == 4);
  const auto heard = testbed.cable->take();
  REQUIRE(heard.size() >= 3);
  CHECK(heard[0].type() == PacketType::stop);
  CHECK(heard[1].message_type() == type_wakeup);  // robots that run from before stand
  CHECK(heard[2].message_type() == 120);
  for (const auto& one : heard)
    CHECK((one.type() == PacketType::stop || one.message_type() == type_wakeup || one.message_type() == 120));

  // the answer is there: silence
  testbed.eyes_see->question.reset();
  testbed.frame(5);
  REQUIRE(!testbed.cable->heard.empty());
  CHECK(testbed.cable->heard.back().type() == PacketType::stop);
}

TEST_CASE("kilobot arena: not ready in time") {
  // When the wait is over the sentence names what is missing: robots by id, pictures, or the overhead controller.
  Testbed nameless("kilobot.names_within_s = 20");
  nameless.eyes_see->in_doubt = {1, 2, 3};
  const std::string said = nameless.failure();
  CAPTURE(said);
  CHECK(has_part(said, "within 20 s: 3 of 4 robots have not been seen and identified (1-3)"));

  Testbed blind("kilobot.names_within_s = 20");
  blind.eyes_see->covered = true;
  CHECK(has_part(blind.failure(), "the cameras deliver no picture"));

  Testbed mute("kilobot.names_within_s = 20");
  mute.cable->plugged = false;
  CHECK(has_part(mute.failure(), "there is no cable"));
}

TEST_CASE("kilobot arena: begins without somebody") {
  // When the wait is over, as many robots as may be missing are counted and left out; one more ends the lab, and so
  // does an operator, at once.
  Testbed testbed("kilobot.names_within_s = 20\nkilobot.may_miss = 1");
  testbed.eyes_see->in_doubt = {2};
  testbed.frame(0);
  CHECK(testbed.arena->counters()["robots.missing_at_start"] == 1);
  CHECK(testbed.arena->poses().latest().has_value());

  for (const int looks : {2, 3, 7}) {  // pictures come more slowly than looks: when the wait is over there may be none
    Testbed slow("kilobot.names_within_s = 20\nkilobot.may_miss = 1");
    slow.eyes_see->looks_for_picture = looks;
    slow.eyes_see->in_doubt = {2};
    slow.frame(0);
    CHECK(slow.arena->counters()["robots.missing_at_start"] == 1);
    Testbed nameless("kilobot.names_within_s = 20");
    nameless.eyes_see->looks_for_picture = looks;
    nameless.eyes_see->in_doubt = {1, 2, 3};
    CHECK(has_part(nameless.failure(), "within 20 s: 3 of 4 robots have not been seen and identified (1-3)"));
  }

  Testbed two("kilobot.names_within_s = 20\nkilobot.may_miss = 1");
  two.eyes_see->in_doubt = {2, 3};
  CHECK(has_part(two.failure(), "2 of 4 robots have not been seen and identified (2, 3)"));

  Testbed stopped("kilobot.names_within_s = 20\nkilobot.may_miss = 1");
  stopped.eyes_see->in_doubt = {2};
  const TimePoint begun = stopped.wall.now();
  stopped.stops.wished = [&] { return stopped.wall.now() - begun > 5s; };
  const std::string said = stopped.failure();
  CHECK(has_part(said, "stopped by the operator; waited for the testbed: 1 of 4 robots"));
  CHECK(stopped.wall.now() - begun < 7s);
}

TEST_CASE("kilobot arena: real time") {
  // Lab time begins with the first later call, however long after frame 0, and each frame is looked at in its moment.
  Testbed testbed;
  testbed.frame(0);
  testbed.wall.pass(10min);
  const TimePoint start = testbed.wall.now();
  testbed.eyes_see->looked_at.clear();
  testbed.frame(20);
  CHECK(testbed.wall.now() - start == 2s);
  REQUIRE(testbed.eyes_see->looked_at.size() == 20);
  for (std::size_t i = 1; i < 20; ++i)
    CHECK(testbed.eyes_see->looked_at[i] - testbed.eyes_see->looked_at[i - 1] == 100ms);
  const auto frame = testbed.arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->number == 20);
  CHECK(frame->stamp == 2s);
  CHECK(testbed.arena->counters()["poses.skipped"] == 20);
  CHECK(testbed.arena->counters()["late"] == 0);
  testbed.wall.pass(1s);
  testbed.frame(21);
  CHECK(testbed.arena->counters()["late"] == 1);
}

TEST_CASE("kilobot arena: nothing blocks") {
  // Every call returns before any time has passed; what is waited for can be read meanwhile, and lab time stands still.
  Testbed testbed("kilobot.names_within_s = 20");
  testbed.eyes_see->in_doubt = {1};
  const TimePoint begun = testbed.wall.now();
  CHECK(testbed.arena->waiting_for().empty());
  CHECK_FALSE(testbed.arena->advance_to(0us));
  CHECK(has_part(testbed.arena->waiting_for(), "the testbed: the overhead controller is starting"));
  CHECK(testbed.wall.now() == begun);
  while (testbed.wall.now() - begun < 5s) {
    CHECK_FALSE(testbed.arena->advance_to(0us));
    CHECK(testbed.arena->next_service() > testbed.wall.now());
    CHECK(testbed.arena->next_service() <= testbed.wall.now() + 20ms);
    testbed.wall.wait_until(testbed.arena->next_service());
  }
  CHECK(has_part(testbed.arena->waiting_for(), "the testbed: 1 of 4 robots"));
  CHECK_FALSE(testbed.arena->poses().latest());
  testbed.eyes_see->in_doubt.clear();
  testbed.frame(0);
  CHECK(testbed.arena->waiting_for().empty());
  CHECK_FALSE(testbed.arena->advance_to(100ms));
  CHECK(testbed.arena->clock().now() == 0us);
}

TEST_CASE("kilobot arena: while a lab waits") {
  // Before lab time begins the eyes are kept open and the controller is served, and no lab time passes.
  Testbed testbed("kilobot.again_s = 0");
  testbed.frame(0);
  REQUIRE(testbed.arena->poses().latest());
  const int looks = testbed.eyes_see->looks;
  testbed.cable->take();
  testbed.arena->robots().command({Kind::run});
  for (const TimePoint end = testbed.wall.now() + 3s; testbed.wall.now() < end; testbed.wall.pass(10ms))
    testbed.arena->serve();
  CHECK(testbed.eyes_see->looks == looks + 29);
  CHECK(testbed.arena->clock().now() == 0us);
  CHECK_FALSE(testbed.arena->poses().latest());
  const auto heard = testbed.cable->take();
  REQUIRE(heard.size() == 2);
  CHECK(heard[0].message_type() == type_run);
  CHECK(heard[1].type() == PacketType::stop);
  testbed.frame(1);
  CHECK(testbed.arena->poses().latest()->number == 1);
}

TEST_CASE("kilobot arena: camera gone and back") {
  // Without pictures there are no frames, which is counted, and their numbers stay free; with pictures it goes on.
  Testbed testbed;
  testbed.frame(0);
  REQUIRE(testbed.arena->poses().latest());
  testbed.eyes_see->covered = true;
  for (int n = 1; n <= 30; ++n) {
    testbed.frame(n);
    CHECK_FALSE(testbed.arena->poses().latest());
  }
  CHECK(testbed.arena->counters()["poses.lost.no_picture"] == 30);
  CHECK(testbed.arena->counters()["camera.gone"] == 30);
  testbed.eyes_see->covered = false;
  testbed.frame(31);
  const auto frame = testbed.arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->number == 31);
  CHECK(frame->stamp == 3100ms);
}

TEST_CASE("kilobot arena: what eyes must not invent") {
  // Robots that nobody expects and places off the arena are left out and counted; a little over the edge is the edge.
  Testbed testbed;
  testbed.eyes_see->robots = {0, 1, 7};
  testbed.eyes_see->x_m = 0.51;
  testbed.frame(0);
  auto frame = testbed.arena->poses().latest();
  REQUIRE(frame);
  REQUIRE(frame->robots.size() == 2);
  CHECK(frame->robots[0].pose.x_m == 0.5);
  CHECK(testbed.arena->counters()["poses.refused.unknown_robot"] == 1);
  testbed.eyes_see->x_m = 0.6;
  testbed.frame(1);
  frame = testbed.arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->robots.empty());
  CHECK(testbed.arena->counters()["poses.refused.outside"] == 2);
}

TEST_CASE("kilobot arena: swapped robots") {
  // From the look that finds two robots in doubt until they are named again nothing is said to them, and the others
  // hear as ever.
  Testbed testbed;
  testbed.frame(0);
  testbed.arena->robots().command({Kind::run});
  testbed.frame(10);
  int asked = 0, said = 0;
  for (int n = 11; n <= 70; ++n) {
    if (n == 20) testbed.eyes_see->in_doubt = {1, 2}, testbed.eyes_see->question = Message{{}, 119, 0};
    if (n == 40) testbed.eyes_see->in_doubt.clear(), testbed.eyes_see->question.reset();
    for (hal::RobotId robot = 0; robot < 4; ++robot) testbed.say(robot);
    testbed.cable->take();
    testbed.frame(n);
    int to_doubtful = 0, to_others = 0, questions = 0;
    for (const auto& one : testbed.cable->heard) {
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
  CHECK(testbed.arena->counters()["to_robots.withheld.doubtful"] >= 38);
}

TEST_CASE("kilobot arena: overhead controller gone and back") {
  // Frames go on while the controller is gone; old broadcasts expire, and what robots should do is said when it is
  // back.
  Testbed testbed("kilobot.again_s = 0");
  testbed.frame(0);
  testbed.cable->plugged = false;
  testbed.arena->robots().command({Kind::run});
  testbed.arena->robots().command({Kind::broadcast, 9, {1}});
  for (int n = 1; n <= 80; ++n) {
    testbed.frame(n);
    CHECK(testbed.arena->poses().latest());
  }
  CHECK(testbed.arena->counters()["fleet_command.expired"] == 1);
  CHECK(testbed.arena->counters()["overhead.port_lost"] == 1);
  testbed.cable->plugged = true;
  testbed.cable->take();
  testbed.arena->robots().command({Kind::voltage});
  testbed.frame(150);
  const auto heard = testbed.cable->take();
  REQUIRE(heard.size() == 3);
  CHECK(heard[1].message_type() == type_voltage);
  CHECK(heard[2].type() == PacketType::stop);
}

TEST_CASE("kilobot arena: the last word") {
  // An arena that ends tells its robots to stand until they were seen to, and then tells the controller to stop, which
  // would otherwise repeat it for ever. So it is whether somebody asks it to end or takes it away.
  for (const auto& row : {std::pair(false, false), {true, false}, {false, true}, {true, true}}) {
    const auto& [ran, asked] = row;
    CAPTURE(row.first);
    CAPTURE(row.second);
    Testbed testbed;
    testbed.frame(0);
    if (ran) testbed.arena->robots().command({Kind::run});
    testbed.frame(10);
    testbed.cable->take();
    testbed.say(1);
    const TimePoint end = testbed.wall.now();
    if (asked) hal::end(*testbed.arena, testbed.wall);
    const TimePoint ended = testbed.wall.now();
    if (asked && ran) CHECK(testbed.arena->not_standing().empty());
    testbed.arena.reset();
    if (asked) CHECK(testbed.wall.now() == ended);
    if (ran) {
      REQUIRE(!testbed.cable->heard.empty());
      CHECK(testbed.cable->heard.front().message_type() == type_wakeup);
      CHECK(testbed.cable->heard.back().type() == PacketType::stop);
    }
    const auto took = testbed.wall.now() - end;
    CHECK(took <= (ran ? 3500ms : 600ms));
    if (ran) CHECK(took >= 2500ms);
  }
}

TEST_CASE("kilobot arena: robots that walk on are told to stand for 10 s, and named") {
  Testbed testbed;
  testbed.frame(0);
  testbed.arena->robots().command({Kind::run});
  testbed.frame(10);
  testbed.cable->take();
  const TimePoint begin = testbed.wall.now();
  while (!testbed.arena->end()) {
    testbed.eyes_see->x_m = 0.004 * std::chrono::duration<double>(testbed.wall.now() - begin).count();
    hal::wait_for_service(*testbed.arena, testbed.wall);
  }
  CHECK(testbed.wall.now() - begin >= 10s);
  CHECK(testbed.wall.now() - begin <= 10500ms);
  CHECK(hal::in_words(testbed.arena->not_standing()) == "0-3 (moving)");
  const auto heard = testbed.cable->take();
  CHECK(std::ranges::count_if(heard, [](const auto& one) { return one.message_type() == type_wakeup; }) >= 15);
  CHECK(testbed.arena->counters()["robots.moved_when_told_to_stand"] == 4);
}

TEST_CASE("kilobot arena: a connection is reset while most robots walk or turn on, and only where they ran over it") {
  for (const bool ran : {true, false})
    for (const bool turn : {true, false}) {
      CAPTURE(ran);
      CAPTURE(turn);
      Testbed testbed;
      testbed.cable->connects = true;
      testbed.frame(0);
      if (ran) testbed.arena->robots().command({Kind::run});
      for (int n = 1; n < 80; ++n) {
        (turn ? testbed.eyes_see->turned_rad : testbed.eyes_see->x_m) += turn ? 0.1 : 0.001;
        if (n == 40) testbed.arena->robots().command({Kind::pause});
        testbed.frame(n);
      }
      CHECK(testbed.arena->counters()["overhead.connection_reset"] == (ran ? 1 : 0));
    }
}

TEST_CASE("kilobot arena: while robots walk on, messages for single robots wait and little is said") {
  // A line that takes bytes and brings none passes on all of them later, and robots hear the last.
  Testbed testbed;
  testbed.frame(0);
  testbed.arena->robots().command({Kind::run});
  testbed.frame(10);
  testbed.arena->robots().command({Kind::pause});
  const auto words_and_packets = [&](int from, int to, double speed_m_per_s) {
    testbed.cable->take();
    for (int n = from; n < to; ++n) {
      testbed.eyes_see->x_m += speed_m_per_s * 0.1;
      testbed.arena->robots().offer(std::vector<hal::ToRobot>{{1, 0, 2, static_cast<std::uint16_t>(n)}});
      testbed.frame(n);
    }
    const auto heard = testbed.cable->take();
    return std::pair(std::ranges::count_if(heard, [](const auto& one) { return !robots_of(one.packet).empty(); }),
                     heard.size());
  };
  const auto [words_walking, packets_walking] = words_and_packets(11, 91, 0.01);
  CHECK(words_walking == 0);
  CHECK(packets_walking < 60);  // of the 145 that 8 s have room for
  const auto [words_standing, packets_standing] = words_and_packets(91, 171, 0);
  CHECK(words_standing > 40);
  CHECK(packets_standing > packets_walking);
}

TEST_CASE("kilobot arena: whoever is out of sight, or was not told, is not said to stand") {
  // Robots are judged from when the word went out; before, they were not told.
  Testbed testbed;
  testbed.frame(0);
  testbed.arena->robots().command({Kind::run});
  testbed.frame(30);
  CHECK(testbed.arena->not_standing().empty());
  testbed.cable->plugged = false;
  testbed.arena->robots().command({Kind::pause});
  testbed.frame(60);
  CHECK(hal::in_words(testbed.arena->not_standing()) == "0-3 (not sent yet)");
  testbed.cable->plugged = true;
  testbed.frame(95);  // 0.25 s to find the line, 2.5 s to settle, 0.5 s for the word
  CHECK(hal::in_words(testbed.arena->not_standing()) == "0-3 (still watched)");
  testbed.frame(120);
  CHECK(testbed.arena->not_standing().empty());
  testbed.eyes_see->covered = true;
  testbed.frame(130);
  CHECK(hal::in_words(testbed.arena->not_standing()) == "0-3 (not in sight)");
}

TEST_CASE("kilobot arena: robots are told to stand before the experiment, also by a lab that never begins") {
  // Robots that run from before hear it as soon as the controller listens, although nobody was found yet.
  Testbed testbed;
  testbed.eyes_see->named_after_looks = 1'000'000;
  const TimePoint until = testbed.wall.now() + 5s;
  while (testbed.wall.now() < until && !testbed.arena->advance_to(hal::LabTime{0}))
    hal::wait_for_service(*testbed.arena, testbed.wall);
  const auto heard = testbed.cable->take();
  REQUIRE(heard.size() >= 2);
  CHECK(heard[1].message_type() == type_wakeup);
  hal::end(*testbed.arena, testbed.wall);
  for (const auto& one : testbed.cable->take())
    CHECK((one.type() == PacketType::stop || one.message_type() == type_wakeup));
}
