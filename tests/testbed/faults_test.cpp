// Faults on a table of Kilobots while an experiment runs: it degrades, says so, recovers, and never invents a pose.
#include <doctest/doctest.h>

#include "tests/testbed/virtual_table.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;

namespace {

// Steps until the condition holds; false after `seconds`. No frame on the way says anything wrong.
bool soon(VirtualTable& table, double seconds, const std::function<bool()>& condition) {
  for (int n = 0; n < std::lround(seconds * 10); ++n) {
    table.step();
    CHECK(table.wrong() == 0);
    if (condition()) return true;
  }
  return false;
}
bool everybody_soon(VirtualTable& table, double seconds, int robots = VirtualTable::robots) {
  return soon(table, seconds, [&] { return table.frame && table.right() == robots; });
}

}  // namespace

TEST_CASE("table: cameras and controller fail and come back") {
  // A camera that is gone, frozen or dark, a controller that is unplugged and garbage on its line: counters show it
  // where there is something to count, no frame is wrong meanwhile, and afterwards all robots are where frames say.
  VirtualTable table;
  table.start();
  REQUIRE(everybody_soon(table, 2));

  table.happen("camera camera0 gone");
  std::uint64_t before = table.counted("poses.lost.no_picture");
  table.steps(2, [&] { CHECK(!table.frame); });
  CHECK(table.counted("poses.lost.no_picture") - before >= 19);
  CHECK(table.counted("camera.gone") == 1);
  table.happen("camera camera0 ok");
  CHECK(everybody_soon(table, 20));

  table.happen("camera camera0 frozen");
  before = table.counted("camera.frozen");
  table.steps(2, [&] { CHECK(table.wrong() == 0); });
  CHECK(table.counted("camera.frozen") > before);
  table.happen("camera camera0 ok");
  CHECK(everybody_soon(table, 20));

  table.happen("camera camera0 dark");
  table.steps(2, [&] { CHECK(table.wrong() == 0); });
  table.happen("camera camera0 ok");
  CHECK(everybody_soon(table, 20));

  table.happen("ohc unplug");
  table.steps(2, [&] { CHECK(table.wrong() == 0); });
  table.happen("ohc plug");
  table.happen("ohc garbage 500");
  CHECK(everybody_soon(table, 20));
  const std::uint64_t sent = table.arena->robots().airtime().sent;
  CHECK(soon(table, 10, [&] { return table.arena->robots().airtime().sent > sent; }));
}

TEST_CASE("table: a camera is knocked about") {
  // Whether by 3 mm or so far that no mark is where it was: from then on no frame is made from places that are off, the
  // counters say so, and frames come again when it is clear where the camera hangs now, also when it is put back.
  // Turned away it shows nothing until then.
  struct Row {
    const char* knock;
    bool followed;
  };
  for (const Row& row : {Row{"0 0.003", true}, Row{"0.03 -0.02 2", true}, Row{"0.4 0.3 40", false}}) {
    CAPTURE(row.knock);
    VirtualTable table;
    table.start();
    REQUIRE(everybody_soon(table, 2));
    const auto off_m = [&] {
      double most = 0;
      for (const hal::Sighting& seen : table.frame ? table.frame->robots : std::vector<hal::Sighting>{})
        if (const auto at = table.truth(seen.robot))
          most = std::max(most, std::hypot(at->x_m - seen.pose.x_m, at->y_m - seen.pose.y_m));
      return most;
    };
    for (const std::string& command :
         {std::string("camera camera0 move ") + row.knock, std::string("camera camera0 ok")}) {
      const std::uint64_t lost = table.counted("poses.lost.no_picture"), moved = table.counted("camera.moved");
      const bool back = command.ends_with("ok");
      table.happen(command);
      table.step();
      CHECK(table.frame.has_value() == (back && !row.followed));
      table.steps(10, [&] { CHECK(off_m() < 0.003); });
      CHECK(table.counted("camera.moved") == moved + row.followed);
      CHECK(table.counted("poses.lost.no_picture") > lost - back);
      if (row.followed || back)
        CHECK(table.right() == VirtualTable::robots);
      else
        CHECK(!table.frame);
    }
    CHECK(table.counted("camera.realigned") == (row.followed ? 2 : 0));
  }
}

TEST_CASE("table: a robot is taken away and put elsewhere") {
  // A robot off the table is in no frame for long; put elsewhere it is named again and in its new place.
  VirtualTable table;
  table.start();
  REQUIRE(everybody_soon(table, 2));

  const auto id_of = [&](int number) { return table.emulator().truth()[static_cast<std::size_t>(number)].id; };
  table.happen("robot 3 take");
  CHECK(soon(table, 10, [&] {
    return table.frame &&
           std::ranges::none_of(table.frame->robots, [&](const auto& seen) { return seen.robot == id_of(3); });
  }));
  table.steps(1, [&] { CHECK(table.right() >= VirtualTable::robots - 1); });
  table.happen("robot 3 put 0.2 -0.2 90");
  CHECK(everybody_soon(table, 20));
}

TEST_CASE("table: two robots swapped by hand") {
  // Lifted for 1.5 s and put down in each other's place: nothing is said to either until it is named again, which takes
  // less than 20 s, and no frame ever has one in the place of the other.
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    CAPTURE(seed);
    VirtualTable table("", seed);
    table.start();
    REQUIRE(everybody_soon(table, 2));
    table.steps(3);
    const std::vector<hal::RobotId> swapped{table.emulator().truth()[1].id, table.emulator().truth()[5].id};
    table.happen("swap 1 5 1.5");
    table.steps(1.5, [&] { CHECK(table.wrong() == 0); });
    const hal::LabTime down = table.now();
    std::uint64_t withheld = table.counted("to_robots.withheld.doubtful");
    bool both = false;
    while (!both && table.now() - down < hal::LabTime{20'000'000}) {
      table.step();
      CHECK(table.wrong() == 0);
      both = table.right(swapped[0]) && table.right(swapped[1]);
      if (both) break;
      // What step() said to those who are not named was not sent.
      const bool first = table.right(swapped[0]), second = table.right(swapped[1]);
      const std::uint64_t now = table.counted("to_robots.withheld.doubtful");
      CHECK(now - withheld >= static_cast<std::uint64_t>(!first + !second));
      withheld = now;
    }
    CHECK(both);
    MESSAGE("named again " << static_cast<double>((table.now() - down).count()) * 1e-6
                           << " s after they were put down");
  }
}

TEST_CASE("table: swapped while nobody can see or hear it") {
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
    VirtualTable table;
    table.start();
    REQUIRE(everybody_soon(table, 2));
    table.steps(2);
    double now_s = 0;
    for (const auto& [at_s, fault] : story) {
      table.steps(at_s - now_s, [&] { CHECK(table.wrong() == 0); });
      now_s = at_s;
      table.happen(fault);
    }
    table.steps(1.5, [&] { CHECK(table.wrong() == 0); });
    CHECK(everybody_soon(table, 20));
    CHECK(table.said_blindly() == 0);
  }
}

TEST_CASE("table: a robot dies and comes back, while the line to the controller is noisy") {
  // Bytes are spoilt and no frame puts anybody in a wrong place. The dead robot is seen dark where it lies; powered and
  // told to run again, it shines and drives.
  VirtualTable table;
  table.start();
  REQUIRE(everybody_soon(table, 2));
  const hal::RobotId id = table.emulator().truth()[2].id;
  const auto led = [&] {
    for (const hal::Sighting& seen : table.frame ? table.frame->robots : std::vector<hal::Sighting>{})
      if (seen.robot == id) return seen.led;
    return hal::Led::off;
  };
  REQUIRE(soon(table, 3, [&] { return led() != hal::Led::off; }));
  table.happen("ohc noise 0.002");  // a quarter of the packets is spoilt
  table.happen("robot 2 kill");
  CHECK(soon(table, 3, [&] { return table.right(id) && led() == hal::Led::off; }));
  table.steps(2, [&] { CHECK((table.wrong() == 0 && led() == hal::Led::off)); });
  const auto lay = table.truth(id);
  table.happen("robot 2 revive");
  table.arena->robots().command({hal::FleetCommand::Kind::run});
  CHECK(soon(table, 20, [&] {
    const auto at = table.truth(id);
    return table.right(id) && led() != hal::Led::off && std::hypot(at->x_m - lay->x_m, at->y_m - lay->y_m) > 0.01;
  }));
  CHECK(everybody_soon(table, 20));
  CHECK(table.emulator().counters()["line.bytes_spoilt"] > 0);
}
