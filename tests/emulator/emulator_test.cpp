// The emulator as a whole, without wall time: its serial line, its robots, and what can go wrong.
#include "emulator/emulator.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "tests/emulator/emulator_builder.hpp"

using namespace arkmesh;
using namespace arkmesh::emulator;

namespace {

double mean_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total() * 3);
}

}  // namespace

TEST_CASE("an emulator's robots obey the serial line and nothing else") {
  // RUN starts the unmodified controller, whose LEDs show the ids; a broadcast reaches it; PAUSE and RESET do what they
  // do on robots.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  emulator.advance_to(ms(2'100));
  CHECK(led_of(emulator, 1) == hal::Led::off);
  say(emulator, make_packet(2, {}, 0x88), ms(300));
  CHECK(led_of(emulator, 0) == hal::Led::off);
  CHECK(led_of(emulator, 1) == hal::Led::red);
  say(emulator, make_packet(2, {0}, 7), ms(300));
  CHECK(led_of(emulator, 0) == hal::Led::white);
  CHECK(led_of(emulator, 1) == hal::Led::off);
  say(emulator, make_packet(2, {}, 0x83), ms(300));
  CHECK(led_of(emulator, 0) == hal::Led::off);
  CHECK(emulator.counters()["ohc.packets.forward"] == 3);
  CHECK(emulator.counters()["overhead.heard"] > 60);
}

TEST_CASE("bytes that come while a message is on the air distort it for everybody") {
  // Packets 38 ms apart, each with another message: nobody hears any; 60 ms apart everybody hears all.
  for (const auto& [spacing, heard] : {std::pair{ms(38), false}, {ms(60), true}}) {
    Emulator emulator = TestEmulator{.robots = 2}.make();
    emulator.advance_to(ms(2'100));
    say(emulator, make_packet(2, {}, 0x88), ms(300));
    say(emulator, make_packet(0, {}), ms(100));
    CHECK(led_of(emulator, 1) == hal::Led::red);
    for (int k = 0; k < 30; ++k) say(emulator, make_packet(2, {1, k}, 7), spacing);
    CHECK((led_of(emulator, 1) == hal::Led::white) == heard);
    CHECK(emulator.counters()["overhead.distorted"] > 20);
  }
}

TEST_CASE("ids are to be found out") {
  // Shuffled: every id once, in another order for another seed; unassigned: 65535 all over; always what the program
  // sees.
  const std::string ten =
      "-0.2,0,0, -0.16,0,0, -0.12,0,0, -0.08,0,0, -0.04,0,0, 0,0,0, 0.04,0,0, 0.08,0,0, 0.12,0,0, 0.16,0,0";
  std::vector<std::vector<std::uint16_t>> orders;
  for (const char* const seed : {"seed = 1", "seed = 2", "seed = 1"}) {
    const Emulator emulator = TestEmulator{.poses = ten, .robots = 10, .emulator = seed}.make();
    std::vector<std::uint16_t> ids;
    for (const Emulator::Truth& robot : emulator.truth()) ids.push_back(robot.id);
    orders.push_back(ids);
    std::ranges::sort(ids);
    for (std::size_t k = 0; k < ids.size(); ++k) CHECK(ids[k] == k);
  }
  CHECK(orders[0] != orders[1]);
  CHECK(orders[0] == orders[2]);
  Emulator blank = TestEmulator{.poses = ten, .robots = 10, .emulator = "ids = \"unassigned\""}.make();
  for (const Emulator::Truth& robot : blank.truth()) CHECK(robot.id == 65'535);
  blank.advance_to(ms(2'100));
  say(blank, make_packet(2, {}, 0x88), ms(300));
  CHECK(led_of(blank, 3) == hal::Led::white);
  // an id set and saved over the air stays through a reset
  say(blank, make_packet(2, {1, 42, 0}, 0x8A), ms(300));
  say(blank, make_packet(2, {0}, 0x8A), ms(300));
  say(blank, make_packet(2, {}, 0x83), ms(300));
  CHECK(blank.truth()[3].id == 42);
}

TEST_CASE("a firmware upload resets robots when all pages have come") {
  // BOOT, the number of pages, then pages 165 ms apart; a page that is missing is written in the next round.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  emulator.advance_to(ms(2'100));
  say(emulator, make_packet(2, {}, 0x88), ms(300));
  CHECK(led_of(emulator, 1) == hal::Led::red);
  say(emulator, make_packet(2, {}, 0x80), ms(300));
  say(emulator, make_packet(2, {3}, 0x82), ms(200));
  for (int page : {0, 2}) say(emulator, make_packet(4, {page, 1, 2, 3}), ms(165));
  CHECK(emulator.counters()["robots.pages_written"] == 4);
  CHECK(led_of(emulator, 1) == hal::Led::green);
  say(emulator, make_packet(2, {}, 0x88), ms(300));  // no way out with half a program
  CHECK(led_of(emulator, 1) == hal::Led::green);
  for (int page : {0, 1}) say(emulator, make_packet(4, {page, 1, 2, 3}), ms(165));
  CHECK(emulator.counters()["robots.pages_written"] == 6);
  CHECK(led_of(emulator, 1) == hal::Led::off);
  say(emulator, make_packet(2, {}, 0x88), ms(300));
  CHECK(led_of(emulator, 1) == hal::Led::red);
}

TEST_CASE("robots are taken, put, killed and revived by hand") {
  // Positions are those asked for; impossible ones are refused in words; a dead robot is dark and forgets that it ran.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  emulator.advance_to(ms(2'100));
  say(emulator, make_packet(2, {}, 0x88), ms(300));
  CHECK(emulator.command("robot 1 take") == "ok");
  CHECK_FALSE(emulator.truth()[1].seen.in_arena);
  say(emulator, make_packet(2, {1}, 7), ms(300));
  CHECK(led_of(emulator, 1) == hal::Led::red);  // heard nothing
  CHECK(emulator.command("robot 1 put 0.2 0.1 90") == "ok");
  CHECK(emulator.truth()[1].seen.in_arena);
  CHECK(emulator.truth()[1].seen.pose.x_m == 0.2);
  CHECK(emulator.truth()[1].seen.pose.heading_rad == doctest::Approx(1.5708));
  const std::string by_id = fmt::format("robot id:{}", emulator.truth()[1].id);
  CHECK(emulator.command(by_id + " put 0.1 -0.1") == "ok");
  CHECK(emulator.truth()[1].seen.pose.y_m == -0.1);
  CHECK(emulator.truth()[1].seen.pose.heading_rad == doctest::Approx(1.5708));  // its own
  CHECK(emulator.command(by_id + " put 0.2 0.1") == "ok");
  CHECK(emulator.command("robot 0 put 0.2 0.1 0").find("robot 1 stands there") != std::string::npos);
  CHECK(emulator.command("robot 0 put 5 0 0").find("not completely inside") != std::string::npos);
  CHECK(emulator.command("robot 1 kill") == "ok");
  emulator.advance_to(emulator.now() + ms(100));
  CHECK(led_of(emulator, 1) == hal::Led::off);
  say(emulator, make_packet(2, {1}, 7), ms(300));
  CHECK(led_of(emulator, 1) == hal::Led::off);
  CHECK(emulator.command("robot 1 revive") == "ok");
  say(emulator, make_packet(2, {}, 0x88), ms(300));
  CHECK(led_of(emulator, 1) == hal::Led::red);
}

TEST_CASE("two robots are swapped by hands, seen while they do it") {
  // Each ends where the other was, with its own id; meanwhile both are off the arena under hands.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  emulator.advance_to(ms(1'000));
  cv::Mat before, during;
  REQUIRE(emulator.picture(0, before));
  const auto first = emulator.truth();
  CHECK(emulator.command("swap 0 1 1.5") == "ok");
  CHECK(emulator.command("swap 0 1 1.5").starts_with("error"));
  emulator.advance_to(ms(2'400));
  CHECK_FALSE(emulator.truth()[0].seen.in_arena);
  REQUIRE(emulator.picture(0, during));
  CHECK(mean_difference(before, during) > 3);
  emulator.advance_to(ms(2'600));
  const auto second = emulator.truth();
  for (int k : {0, 1}) {
    const auto i = static_cast<std::size_t>(k), other = 1 - i;
    CHECK(second[i].seen.in_arena);
    CHECK(second[i].id == first[i].id);
    CHECK(second[i].seen.pose.x_m == doctest::Approx(first[other].seen.pose.x_m));
    CHECK(second[i].seen.pose.heading_rad == doctest::Approx(first[other].seen.pose.heading_rad));
  }
}

TEST_CASE("cameras freeze, go dark, vanish and are knocked about") {
  // A frozen picture stays to the bit; a moved camera sees another picture though its calibration stays.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  emulator.advance_to(ms(2'100));
  cv::Mat first, later, dark, moved;
  CHECK(emulator.command("camera camera0 frozen") == "ok");
  REQUIRE(emulator.picture(0, first));
  say(emulator, make_packet(2, {}, 0x88), ms(1'000));
  REQUIRE(emulator.picture(0, later));
  CHECK(cv::norm(first, later, cv::NORM_INF) == 0);
  CHECK(emulator.command("camera camera0 ok") == "ok");
  REQUIRE(emulator.picture(0, later));
  CHECK(cv::norm(first, later, cv::NORM_INF) > 0);
  CHECK(emulator.command("camera camera0 dark") == "ok");
  REQUIRE(emulator.picture(0, dark));
  CHECK(cv::mean(dark)[0] < 8);
  CHECK(emulator.command("camera camera0 gone") == "ok");
  CHECK_FALSE(emulator.picture(0, dark));
  CHECK(emulator.command("camera camera0 ok") == "ok");
  CHECK(emulator.command("camera camera0 move 0.05 0 3") == "ok");
  REQUIRE(emulator.picture(0, moved));
  CHECK(mean_difference(later, moved) > 2);
  CHECK(emulator.camera(0).model_at_first().project(0, 0, 0)->x == doctest::Approx(159.5));
  CHECK(emulator.camera(0).model().project(0.05, 0, 0)->x == doctest::Approx(159.5));
  CHECK(emulator.command("camera camera0 ok") == "ok");
  cv::Mat back;
  REQUIRE(emulator.picture(0, back));
  CHECK(cv::norm(later, back, cv::NORM_INF) == 0);
}

TEST_CASE("an unplugged controller and garbage on its line do no more than they would on hardware") {
  // Bytes are lost while unplugged and during the start-up that follows nothing is acted on; garbage ends nobody's
  // life.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  emulator.advance_to(ms(2'100));
  CHECK(emulator.command("ohc unplug") == "ok");
  say(emulator, make_packet(2, {}, 0x88), ms(300));
  CHECK(led_of(emulator, 1) == hal::Led::off);
  CHECK(emulator.counters()["serial.bytes_lost.unplugged"] == 132);
  CHECK(emulator.command("ohc plug") == "ok");
  say(emulator, make_packet(2, {}, 0x88), ms(1'900));
  CHECK(led_of(emulator, 1) == hal::Led::off);
  emulator.advance_to(emulator.now() + ms(300));
  CHECK(led_of(emulator, 1) == hal::Led::red);
  CHECK(emulator.command("ohc garbage 500") == "ok");
  emulator.advance_to(emulator.now() + ms(500));
  say(emulator, make_packet(2, {1}, 7), ms(300));
  CHECK(led_of(emulator, 1) == hal::Led::white);
  CHECK(emulator.command("ohc noise 0.2") == "ok");
  for (int k = 0; k < 10; ++k) say(emulator, make_packet(2, {0, k}, 7), ms(60));
  CHECK(led_of(emulator, 1) == hal::Led::white);  // no packet came whole
  CHECK(emulator.counters()["serial.bytes_spoilt"] > 100);
}

TEST_CASE("the line takes no more than a port's buffer") {
  // 4096 bytes wait at most, for a second and more; what comes on top is counted.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  emulator.advance_to(ms(100));
  emulator.write_serial(std::vector<std::uint8_t>(5000, 1));
  CHECK(emulator.serial_free() == 0);
  CHECK(emulator.counters()["serial.bytes_lost.overflow"] == 904);
  emulator.advance_to(ms(100) + ms(600));
  CHECK(emulator.serial_free() > 2000);
  emulator.advance_to(ms(1'500));
  CHECK(emulator.serial_free() == 4096);
}

TEST_CASE("what nobody understands is answered with a sentence") {
  // Any text may come over the control port.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  for (const char* const line : {"",
                                 "bogus",
                                 "camera",
                                 "camera nine ok",
                                 "camera camera0 fly",
                                 "camera camera0 move x y",
                                 "ohc",
                                 "ohc garbage -1",
                                 "ohc garbage 99999999999",
                                 "ohc noise 2",
                                 "robot",
                                 "robot 2 take",
                                 "robot -1 take",
                                 "robot 0 put 1",
                                 "robot 0 put 0 0 north",
                                 "robot id: take",
                                 "robot id:65535 take",
                                 "robot id:x take",
                                 "robot 0 put nan 0 0",
                                 "robot 0 dance",
                                 "robot 0 cover 0",
                                 "swap",
                                 "swap 0 0",
                                 "swap 0 1 -1",
                                 "swap 0 1 1e99",
                                 "say",
                                 "say cheese",
                                 "\x01\xff"})
    CHECK(emulator.command(line).starts_with("error: "));
  CHECK(emulator.command("help").find("swap A B SECONDS") != std::string::npos);
  CHECK(emulator.command("status").find("ohc=plugged") != std::string::npos);
}

TEST_CASE("events of the file happen at their times however the emulator is stepped") {
  // In one stride or in small steps: the same pictures and the same truth.
  const std::string events =
      "[[emulator.event]]\nat_s = 2.1\ndo = \"say run\"\n[[emulator.event]]\nat_s = 2.5\ndo = \"swap 0 1 1\"\n"
      "[[emulator.event]]\nat_s = 2.7\ndo = \"nonsense\"";
  cv::Mat pictures[2];
  std::vector<Emulator::Truth> truths[2];
  for (int way : {0, 1}) {
    Emulator emulator =
        TestEmulator{.controller = "tests/sim_ode/controllers/wander.c", .robots = 2, .events = events}.make();
    if (way == 1)
      for (int k = 1; k < 100; ++k) emulator.advance_to(ms(k * 43));
    emulator.advance_to(ms(5'000));
    REQUIRE(emulator.picture(0, pictures[way]));
    truths[way] = emulator.truth();
    CHECK(emulator.counters()["emulator.events_refused"] == 1);
  }
  CHECK(cv::norm(pictures[0], pictures[1], cv::NORM_INF) == 0);
  CHECK(truths[0][0].seen.pose.x_m == truths[1][0].seen.pose.x_m);
  CHECK(std::abs(truths[0][0].seen.pose.x_m - 0.1) < 0.05);
}
