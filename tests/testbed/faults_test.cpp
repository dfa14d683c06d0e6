// Faults on a testbed of Kilobots while an experiment runs: it degrades, says so, recovers, and never invents a pose.
#include <doctest/doctest.h>

#include "tests/testbed/observed_testbed.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;

namespace {

// Steps until the condition holds; false after `seconds`. No frame on the way says anything wrong.
bool soon(ObservedTestbed& testbed, double seconds, const std::function<bool()>& condition) {
  for (int n = 0; n < std::lround(seconds * 10); ++n) {
    testbed.step();
    CHECK(testbed.wrong() == 0);
    if (condition()) return true;
  }
  return false;
}
bool everybody_soon(ObservedTestbed& testbed, double seconds, int robots = ObservedTestbed::robots) {
  return soon(testbed, seconds, [&] { return testbed.frame && testbed.right() == robots; });
}

}  // namespace

TEST_CASE("testbed: cameras and controller fail and come back") {
  // A camera that is gone, frozen or dark, a controller that is unplugged and garbage on its line: counters show it
  // where there is something to count, no frame is wrong meanwhile, and afterwards all robots are where frames say.
  ObservedTestbed testbed;
  testbed.start();
  REQUIRE(everybody_soon(testbed, 2));

  testbed.happen("camera camera0 gone");
  std::uint64_t before = testbed.counted("poses.lost.no_picture");
  testbed.steps(2, [&] { CHECK(!testbed.frame); });
  CHECK(testbed.counted("poses.lost.no_picture") - before >= 19);
  CHECK(testbed.counted("camera.gone") == 1);
  testbed.happen("camera camera0 ok");
  CHECK(everybody_soon(testbed, 20));

  testbed.happen("camera camera0 frozen");
  before = testbed.counted("camera.frozen");
  testbed.steps(2, [&] { CHECK(testbed.wrong() == 0); });
  CHECK(testbed.counted("camera.frozen") > before);
  testbed.happen("camera camera0 ok");
  CHECK(everybody_soon(testbed, 20));

  testbed.happen("camera camera0 dark");
  testbed.steps(2, [&] { CHECK(testbed.wrong() == 0); });
  testbed.happen("camera camera0 ok");
  CHECK(everybody_soon(testbed, 20));

  testbed.happen("ohc unplug");
  testbed.steps(2, [&] { CHECK(testbed.wrong() == 0); });
  testbed.happen("ohc plug");
  testbed.happen("ohc garbage 500");
  CHECK(everybody_soon(testbed, 20));
  const std::uint64_t sent = testbed.arena->robots().airtime().sent;
  CHECK(soon(testbed, 10, [&] { return testbed.arena->robots().airtime().sent > sent; }));
}

TEST_CASE("testbed: a camera is knocked about") {
  // Whether by 3 mm or so far that no mark is where it was: from then on no frame is made from places that are off, the
  // counters say so, and frames come again when it is clear where the camera hangs now, also when it is put back.
  // Turned away it shows nothing until then.
  struct Row {
    const char* knock;
    bool followed;
  };
  for (const Row& row : {Row{"0 0.003", true}, Row{"0.03 -0.02 2", true}, Row{"0.4 0.3 40", false}}) {
    CAPTURE(row.knock);
    ObservedTestbed testbed;
    testbed.start();
    REQUIRE(everybody_soon(testbed, 2));
    const auto off_m = [&] {
      double most = 0;
      for (const hal::Observation& seen : testbed.frame ? testbed.frame->robots : std::vector<hal::Observation>{})
        if (const auto at = testbed.truth(seen.robot))
          most = std::max(most, std::hypot(at->x_m - seen.pose.x_m, at->y_m - seen.pose.y_m));
      return most;
    };
    for (const std::string& command :
         {std::string("camera camera0 move ") + row.knock, std::string("camera camera0 ok")}) {
      const std::uint64_t lost = testbed.counted("poses.lost.no_picture"), moved = testbed.counted("camera.moved");
      const bool back = command.ends_with("ok");
      testbed.happen(command);
      testbed.step();
      CHECK(testbed.frame.has_value() == (back && !row.followed));
      testbed.steps(10, [&] { CHECK(off_m() < 0.003); });
      CHECK(testbed.counted("camera.moved") == moved + row.followed);
      CHECK(testbed.counted("poses.lost.no_picture") > lost - back);
      if (row.followed || back)
        CHECK(testbed.right() == ObservedTestbed::robots);
      else
        CHECK(!testbed.frame);
    }
    CHECK(testbed.counted("camera.realigned") == (row.followed ? 2 : 0));
  }
}

TEST_CASE("testbed: a robot is taken away and put elsewhere") {
  // A robot off the arena is in no frame for long; put elsewhere it is named again and in its new place.
  ObservedTestbed testbed;
  testbed.start();
  REQUIRE(everybody_soon(testbed, 2));

  const auto id_of = [&](int number) { return testbed.emulator().truth()[static_cast<std::size_t>(number)].id; };
  testbed.happen("robot 3 take");
  CHECK(soon(testbed, 10, [&] {
    return testbed.frame &&
           std::ranges::none_of(testbed.frame->robots, [&](const auto& seen) { return seen.robot == id_of(3); });
  }));
  testbed.steps(1, [&] { CHECK(testbed.right() >= ObservedTestbed::robots - 1); });
  testbed.happen("robot 3 put 0.2 -0.2 90");
  CHECK(everybody_soon(testbed, 20));
}

TEST_CASE("testbed: two robots swapped by hand") {
  // Lifted for 1.5 s and put down in each other's place: nothing is said to either until it is named again, which takes
  // less than 20 s, and no frame ever has one in the place of the other.
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    CAPTURE(seed);
    ObservedTestbed testbed("", seed);
    testbed.start();
    REQUIRE(everybody_soon(testbed, 2));
    testbed.steps(3);
    const std::vector<hal::RobotId> swapped{testbed.emulator().truth()[1].id, testbed.emulator().truth()[5].id};
    testbed.happen("swap 1 5 1.5");
    testbed.steps(1.5, [&] { CHECK(testbed.wrong() == 0); });
    const hal::LabTime down = testbed.now();
    std::uint64_t withheld = testbed.counted("to_robots.withheld.doubtful");
    bool both = false;
    while (!both && testbed.now() - down < hal::LabTime{20'000'000}) {
      testbed.step();
      CHECK(testbed.wrong() == 0);
      both = testbed.right(swapped[0]) && testbed.right(swapped[1]);
      if (both) break;
      // What step() said to those who are not named was not sent.
      const bool first = testbed.right(swapped[0]), second = testbed.right(swapped[1]);
      const std::uint64_t now = testbed.counted("to_robots.withheld.doubtful");
      CHECK(now - withheld >= static_cast<std::uint64_t>(!first + !second));
      withheld = now;
    }
    CHECK(both);
    MESSAGE("named again " << static_cast<double>((testbed.now() - down).count()) * 1e-6
                           << " s after they were put down");
  }
}

TEST_CASE("testbed: swapped while nobody can see or hear it") {
  // In the dark, before a camera that is frozen, with the controller unplugged, all of it at once and among three: no
  // frame is ever wrong, nothing is said to a robot that no frame names, and everybody is named again when the last
  // trouble is over.
  const std::vector<std::vector<std::pair<double, const char*>>> stories{
      {{0, "camera camera0 dark"}, {1, "swap 1 5 1.2"}, {3, "camera camera0 ok"}},
      {{0, "camera camera0 frozen"}, {1, "swap 1 5 1.2"}, {10, "camera camera0 ok"}},
      {{0, "ohc unplug"}, {0.5, "swap 1 5 1.2"}, {2, "swap 5 6 1.2"}, {4, "ohc plug"}, {4, "ohc garbage 500"}},
      {{0, "swap 1 5 1.2"},
       {0.5, "ohc unplug"},
       {1, "camera camera0 gone"},
       {2, "camera camera0 move 0.01 0"},
       {2, "swap 2 3 1"},
       {3.5, "camera camera0 ok"},
       {3.5, "ohc plug"}}};
  for (const auto& story : stories) {
    CAPTURE(&story - stories.data());
    ObservedTestbed testbed;
    testbed.start();
    REQUIRE(everybody_soon(testbed, 2));
    testbed.steps(2);
    double now_s = 0;
    for (const auto& [at_s, fault] : story) {
      testbed.steps(at_s - now_s, [&] { CHECK(testbed.wrong() == 0); });
      now_s = at_s;
      testbed.happen(fault);
    }
    testbed.steps(1.5, [&] { CHECK(testbed.wrong() == 0); });
    CHECK(everybody_soon(testbed, 20));
    CHECK(testbed.said_blindly() == 0);
  }
}

TEST_CASE("testbed: a robot dies and comes back, while the line to the controller is noisy") {
  // Bytes are spoilt and no frame puts anybody in a wrong place. The dead robot is seen dark where it lies; powered and
  // told to run again, it shines and drives.
  ObservedTestbed testbed;
  testbed.start();
  REQUIRE(everybody_soon(testbed, 2));
  const hal::RobotId id = testbed.emulator().truth()[2].id;
  const auto led = [&] {
    for (const hal::Observation& seen : testbed.frame ? testbed.frame->robots : std::vector<hal::Observation>{})
      if (seen.robot == id) return seen.led;
    return hal::Led::off;
  };
  REQUIRE(soon(testbed, 3, [&] { return led() != hal::Led::off; }));
  testbed.happen("ohc noise 0.002");  // a quarter of the packets is spoilt
  testbed.happen("robot 2 kill");
  CHECK(soon(testbed, 3, [&] { return testbed.right(id) && led() == hal::Led::off; }));
  testbed.steps(2, [&] { CHECK((testbed.wrong() == 0 && led() == hal::Led::off)); });
  const auto lay = testbed.truth(id);
  testbed.happen("robot 2 revive");
  testbed.arena->robots().command({hal::FleetCommand::Kind::run});
  CHECK(soon(testbed, 20, [&] {
    const auto at = testbed.truth(id);
    return testbed.right(id) && led() != hal::Led::off && std::hypot(at->x_m - lay->x_m, at->y_m - lay->y_m) > 0.01;
  }));
  CHECK(everybody_soon(testbed, 20));
  CHECK(testbed.emulator().counters()["serial.bytes_spoilt"] > 0);
}
