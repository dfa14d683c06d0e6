// infrared = "argos": each rule of ARGoS's plug-in by its figures, measured there; docs/model-truth.md has the table.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "hal/bus/loss.hpp"
#include "tests/sim_ode/heard_warnings.hpp"
#include "tests/sim_ode/standing_robots.hpp"

namespace arkmesh::sim_ode {
namespace {

Settings argos(std::int64_t argos_tick_us = 100'000) {
  Settings out;
  out.infrared = InfraredRules::argos;
  out.argos_tick = hal::LabTime{argos_tick_us};
  return out;
}

// Robots' ticks until ARGoS's tick of that number has come.
int robot_ticks(int argos_ticks, std::int64_t argos_tick_us = 100'000) {
  return static_cast<int>(argos_ticks * argos_tick_us / tick_us);
}

std::vector<hal::Pose> close_together(int robots) {
  std::vector<hal::Pose> out;
  for (int i = 0; i < robots; ++i) out.push_back({0.035 * (i % 3) - 0.035, 0.035 * (i / 3) - 0.035, 0});
  return out;
}

Message typed(std::uint8_t type, std::uint8_t first = 0) {
  Message out;
  out.type = type;
  out.data[0] = first;
  return out;
}

hal::Led led_of(Standing& robots, std::size_t robot = 0) {
  std::vector<hal::Led> seen;
  robots.leds.look(0, seen);
  return seen[robot];
}

}  // namespace

TEST_CASE("argos: when a robot sends") {
  // Alone, each floor(period / tick) + 2 ticks of ARGoS, for the first time in its third, by its period of 100 ms or
  // another one.
  struct Row {
    std::int64_t tick_us;
    int period_ms, first, each;
  };
  for (const Row& row : {Row{100'000, 100, 3, 3}, Row{32'258, 100, 5, 5}, Row{100'000, 300, 5, 5}}) {
    CAPTURE(row.tick_us);
    CAPTURE(row.period_ms);
    Standing one({{0, 0, 0}}, argos(row.tick_us), 1, "argos_reports.c");
    one.inbox.overhead.push_back({1, typed(3, static_cast<std::uint8_t>(row.period_ms / 100)), {}});
    std::vector<int> at;
    while (at.size() < 20) {
      const std::uint64_t before = one.medium.totals().sent;
      one.step();
      if (one.medium.totals().sent > before)
        at.push_back(static_cast<int>(((one.tick + 1) * tick_us - 1) / row.tick_us));
    }
    // two short ticks of ARGoS in one of the robots' cannot be told apart
    const int off = row.tick_us < tick_us ? 2 : 0;
    CHECK(std::abs(at[0] - row.first) <= off);
    CHECK(std::abs(at.back() - at.front() - 19 * row.each) <= off);
    for (std::size_t k = 1; k < at.size(); ++k) CHECK(std::abs(at[k] - at[k - 1] - row.each) <= off);
  }
}

TEST_CASE("argos: success comes a tick after the message was asked for") {
  Standing one({{0, 0, 0}}, argos(), 1, "argos_reports.c");
  int waits = 0, gone = 0;
  for (int k = 0; k < 900; ++k) {
    one.step();
    waits += led_of(one) == hal::Led::red;
    gone += led_of(one) == hal::Led::green;
  }
  // asked for in the robots' tick after ARGoS's: 67 to 100 ms of each 300
  CHECK(waits > 150);
  CHECK(waits < 320);
  CHECK(waits + gone > 880);
}

TEST_CASE("argos: who wins") {
  // Of 600 ticks in which 2, 3, 4, 5, 8 robots that reach each other send all the time, 398, 597, 590, 580 and 596
  // messages went in ARGoS; by the rule 400, 600, 585, 595, 600. A robot that nobody reaches always wins.
  for (const auto& [robots, went] : {std::pair{2, 398}, {3, 597}, {4, 590}, {5, 580}, {8, 596}}) {
    const int senders = robots;
    CAPTURE(senders);
    double sum = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      Standing crowd(close_together(robots), argos(), seed);
      for (int k = 0; k < robot_ticks(600); ++k) crowd.step();
      const auto sent = static_cast<double>(crowd.medium.totals().sent);
      CHECK(std::abs(sent - went) < 80);
      sum += sent / 8;
    }
    MESSAGE(robots << " senders: " << sum << " of 600, in ARGoS " << went);
    CHECK(std::abs(sum - went) < 25);
  }
  Standing apart({{-0.5, 0, 0}, {0.5, 0, 0}}, argos());
  for (int k = 0; k < robot_ticks(600); ++k) apart.step();
  CHECK(apart.medium.totals().sent >= 398);
  CHECK(apart.medium.totals().backed_off == 0);
}

TEST_CASE("argos: range is sharp, and nothing takes from it") {
  // 0.1000 m is heard, 0.1001 m is not; robots and walls between block nothing.
  Standing line({{0, 0, 0}, {0.1, 0, 0}, {-0.1001, 0, 0}, {0.05, 0, 0}}, argos());
  for (int k = 0; k < 900; ++k) line.step();
  CHECK(line.heard(1, 0) > 40);
  CHECK(line.heard(0, 1) > 40);
  CHECK(line.heard(2, 0) == 0);
  CHECK(line.heard(0, 2) == 0);
  const auto red_behind_a_wall = [](const char* rules) {
    auto arena = TestArena{.program = "type_255.c",
                           .robots = 2,
                           .ode = fmt::format("start_poses = [-0.03, 0, 0, 0.03, 0, 0]\ninfrared = \"{}\"", rules),
                           .arena =
                               "obstacles = [{shape = \"wall\", x_m = 0, y_m = 0, heading_deg = 90, length_m = "
                               "0.3, width_m = 0.01}]"}
                     .make_running();
    return std::ranges::count(frame_at(*arena, seconds(5)).robots, hal::Led::red, &hal::Observation::led);
  };
  CHECK(red_behind_a_wall("argos") == 2);
}

TEST_CASE("argos: at most four messages in a tick") {
  // Without conflicts all of eight that send together succeed; the first four are heard, the last four never, which is
  // counted. What the overhead controller has said takes one of the four places, and its repetition another tick's.
  Settings settings = argos();
  settings.argos_ignore_conflicts = true;
  Standing crowd(close_together(8), settings);
  for (int k = 0; k < robot_ticks(800); ++k) crowd.step();
  CHECK(crowd.medium.totals().sent >= 8 * 265);
  for (std::size_t listener = 0; listener < 8; ++listener)
    for (std::size_t sender = 0; sender < 8; ++sender)
      CHECK((crowd.heard(listener, sender) > 0) == (sender != listener && sender < (listener < 4 ? 5u : 4u)));
  CHECK(crowd.medium.totals().crowded == crowd.medium.totals().sent * 7 - crowd.medium.totals().received);
  CHECK(crowd.medium.pairs().deaf > 20);

  Standing told(close_together(8), settings);
  CHECK(told.medium.repeats({0, typed(9, 7), {}}));
  for (int k = 0; k < robot_ticks(600); ++k) told.step();
  CHECK(told.heard(7, 2) > 190);
  CHECK(told.heard(7, 3) == 0);
}

TEST_CASE("argos: a word from overhead is heard in each tick until another one is said") {
  // By the robot that it is for, from 0 mm.
  Standing two({{-0.5, 0, 0}, {0.5, 0, 0}}, argos(), 1, "type_255.c");
  const auto heard_in_100_ticks = [&] {
    std::vector<int> out(2);
    for (int k = 0; k < robot_ticks(100); ++k) {
      two.step();
      for (const Reception& reception : two.inbox.infrared) {
        CHECK(reception.high_gain == 0);
        out[static_cast<std::size_t>(reception.robot)] += reception.message.data[0];
      }
    }
    return out;
  };
  CHECK(heard_in_100_ticks() == std::vector<int>{0, 0});
  two.medium.repeats({0, typed(9, 1), {0, 1}});
  CHECK(heard_in_100_ticks()[0] == doctest::Approx(100).epsilon(0.011));
  two.medium.repeats({0, typed(9, 2), {1, 0}});
  const std::vector<int> both = heard_in_100_ticks();
  CHECK(both[0] == doctest::Approx(100).epsilon(0.011));
  CHECK(both[1] == doctest::Approx(200).epsilon(0.011));
}

TEST_CASE("argos: distances are whole millimetres") {
  // Truncated, in high_gain, with 0 in low_gain; estimate_distance gives the same.
  for (const double mm : {34.0, 45.9, 62.5, 99.9}) {
    CAPTURE(mm);
    Standing pair({{0, 0, 0}, {mm * 0.001, 0, 0}}, argos(), 1, "distance.c");
    pair.inbox.overhead.push_back({1, typed(2, static_cast<std::uint8_t>(mm)), {}});
    int heard = 0;
    for (int k = 0; k < 100; ++k) {
      pair.step();
      for (const Reception& reception : pair.inbox.infrared) {
        ++heard;
        CHECK(reception.low_gain == 0);
        CHECK(reception.high_gain == static_cast<int>(mm));
      }
    }
    CHECK(heard > 5);
    CHECK(led_of(pair) == hal::Led::green);
  }
}

TEST_CASE("argos: each receiver loses by ir_loss, and only by it") {
  Settings settings = argos();
  settings.ir_loss = 0.25;
  Standing trio(close_together(3), settings);
  for (int k = 0; k < robot_ticks(3000); ++k) trio.step();
  const auto& totals = trio.medium.totals();
  CHECK(totals.received + totals.lost == 2 * totals.sent);
  CHECK(static_cast<double>(totals.lost) / static_cast<double>(2 * totals.sent) == doctest::Approx(0.25).epsilon(0.1));
}

TEST_CASE("argos: programs that depend on it do by it what their authors saw, and by a robot's rules are told of") {
  // Opinions in messages of type 255 spread; so does what comes with the checksum of an empty message; and who takes
  // what comes from farther than 100 mm for no word of the overhead controller hears its words.
  const auto run = [](const char* program, const std::string& rules) {
    auto arena = TestArena{.program = program, .robots = 16, .side_m = 0.2, .ode = rules}.make_running();
    frame_at(*arena, seconds(1));
    const Heard warnings;
    std::vector<hal::ToRobot> words;
    for (hal::RobotId id = 0; id < 16; ++id) words.push_back({id, 0, 1, 1});
    arena->robots().offer(words);
    const hal::PoseFrame end = frame_at(*arena, seconds(90));
    arena->end();
    return std::pair{std::ranges::count(end.robots, hal::Led::blue, &hal::Observation::led),
                     fmt::format("{}{}", fmt::join(hal::loss_words(arena->counters()), "; "), warnings.text())};
  };
  for (const auto& [program, sentence] : {std::pair{"best_of_two.c", "types above 127"},
                                          {"empty_checksum.c", "their checksum does not"},
                                          {"near_words.c", "143 mm by assumption, in ARGoS 0"}}) {
    const std::string name = program;
    CAPTURE(name);
    const auto [agree, nothing] = run(program, "infrared = \"argos\"");
    CHECK(agree == 16);
    CHECK(nothing.empty());
    const auto [few, told] = run(program, "");
    CHECK(few <= 12);
    CHECK(told.find(sentence) != std::string::npos);
  }
  CHECK(run("near_words.c", "overhead_distance_m = 0.05").first == 16);
}

TEST_CASE("argos: keys of a robot's light are refused") {
  const auto refusal = [](const std::string& ode) {
    try {
      TestArena{.ode = "infrared = \"argos\"\n" + ode}.make();
    } catch (const hal::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(TestArena{.ode = "infrared = \"argos\""}.make()->info().platform == "ode (infrared: argos)");
  CHECK(refusal("preset = \"measured\"\nir_range_m = 0.2\nir_loss = 0.1").empty());
  CHECK(refusal("ir_noise_m = 0.002").find("arena.ode.ir_noise_m = 0.002: applies to infrared = \"robot\" only") !=
        std::string::npos);
  CHECK(refusal("argos_tick_s = 0").find("argos_tick_s") != std::string::npos);
}

TEST_CASE("argos: the same seed gives the same, another seed something else") {
  const auto run = [](std::uint64_t seed) {
    Standing crowd(close_together(9), argos(), seed);
    for (int k = 0; k < 900; ++k) crowd.step();
    return crowd.heard_by;
  };
  CHECK(run(1) == run(1));
  CHECK(run(1) != run(2));
}

}  // namespace arkmesh::sim_ode
