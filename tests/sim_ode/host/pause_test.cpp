// The robots' programs that the project ships go on after a pause: each beside a twin of its swarm that nobody paused.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <numbers>
#include <string>
#include <vector>

#include "sim_ode/controller_swarm.hpp"

namespace arkmesh::sim_ode {
namespace {

using Kind = hal::FleetCommand::Kind;

constexpr int robots = 48;
// Seconds of lab time. The pause is short, so that most robots would still move as they did when it began.
constexpr double pause_s = 9, run_s = 10, shown_again_s = run_s + 0.5, goes_on_s = run_s + 1.5;

// A time in which all robots are asked who they are (docs/identification.md).
struct Asked {
  const char* when;
  double from_s = 0, to_s = 0;
};

// What is said to a swarm and when.
struct Said {
  double at_s;
  hal::FleetCommand command;
};

hal::FleetCommand message(std::uint8_t type, std::initializer_list<int> data) {
  hal::FleetCommand out{.kind = Kind::broadcast, .type = type};
  std::size_t k = 0;
  for (const int byte : data) out.data.at(k++) = static_cast<std::uint8_t>(byte);
  return out;
}

// Gives those something to do who wait for a message. A new program that waits for another one adds it here.
std::vector<Said> words() {
  std::vector<Said> out;
  double at_s = 1;
  const auto say = [&](const hal::FleetCommand& command) {
    out.push_back({at_s, command});
    at_s += 0.2;
  };
  // assign_ids.c: draw an id
  say(message(1, {7}));
  // CRE's flying robots: commit yourself every second, and never give up
  say(message(2, {250, 250, 250, 0, 0, 10, 0, 30}));
  // Each third robot. DHTF: rest at a task; CRE: dense resources, and a wall; calibrate_motors.c: turn; light_up.c: be
  // lit.
  constexpr int kind = 1, value = 30 << 5 | 30;
  for (int first = 0; first < robots; first += 9) {
    hal::FleetCommand blocks{.kind = Kind::broadcast, .type = 0};
    for (int i = 0; i < 3; ++i) {
      const int robot = first + 3 * i;
      const auto block = blocks.data.begin() + 3 * i;
      block[0] = static_cast<std::uint8_t>(robot >> 2);
      block[1] = static_cast<std::uint8_t>((robot & 3) << 6 | kind << 2 | value >> 8);
      block[2] = static_cast<std::uint8_t>(value & 255);
    }
    say(blocks);
  }
  return out;
}

struct Picture {
  std::vector<hal::Led> leds = std::vector<hal::Led>(robots);
  std::array<double, robots> path = {};  // so far: metres, and 10 mm for each radian turned
};

// A swarm and what it did, by the tenth of a second.
std::vector<Picture> film(const std::filesystem::path& program, const Asked& asked, bool pauses) {
  SwarmOptions options{.program = program, .robots = robots, .spacing_m = 0.12};
  // standing motors start with a spin-up only
  options.settings = {"ode.start_duty=100"};
  ControllerSwarm swarm(options);
  std::vector<Said> said = words();
  for (double at_s = asked.from_s; at_s < asked.to_s; at_s += 0.2) said.push_back({at_s, message(118, {1 << 6})});
  if (asked.to_s > 0) said.push_back({asked.to_s, message(118, {})});
  if (pauses) {
    said.push_back({pause_s, {.kind = Kind::pause}});
    said.push_back({run_s, {.kind = Kind::run}});
  }
  std::ranges::stable_sort(said, {}, &Said::at_s);

  std::vector<Picture> pictures;
  hal::PoseFrame last;
  const auto look = [&](const hal::PoseFrame& frame) {
    Picture picture = pictures.empty() ? Picture{} : pictures.back();
    for (std::size_t i = 0; i < robots; ++i) {
      const hal::Observation& robot = frame.robots.at(i);
      picture.leds[i] = robot.led;
      if (last.robots.empty()) continue;
      const hal::Pose& before = last.robots[i].pose;
      picture.path[i] +=
          std::hypot(robot.pose.x_m - before.x_m, robot.pose.y_m - before.y_m) +
          0.01 * std::abs(std::remainder(robot.pose.heading_rad - before.heading_rad, 2 * std::numbers::pi));
    }
    pictures.push_back(picture);
    last = frame;
  };
  const auto until = [&](double s) { swarm.run_until(hal::LabTime(std::llround(s * 1e6)), look); };
  for (const Said& word : said) {
    until(word.at_s);
    swarm.arena().robots().command(word.command);
  }
  until(goes_on_s + 0.1);
  return pictures;
}

const Picture& at(const std::vector<Picture>& film, double s) {
  return film.at(static_cast<std::size_t>(std::lround(s * 10)));
}
template <class Is>
double share(Is is) {
  int n = 0;
  for (std::size_t i = 0; i < robots; ++i) n += is(i) ? 1 : 0;
  return n / static_cast<double>(robots);
}
// Metres a second, as the mean of all robots.
double speed(const std::vector<Picture>& film, double from_s, double to_s) {
  double path = 0;
  for (std::size_t i = 0; i < robots; ++i) path += at(film, to_s).path[i] - at(film, from_s).path[i];
  return path / robots / (to_s - from_s);
}
double lit(const std::vector<Picture>& film, double s) {
  return share([&](std::size_t i) { return at(film, s).leds[i] != hal::Led::off; });
}
double of_same_colour(const std::vector<Picture>& film, double a_s, double b_s) {
  return share([&](std::size_t i) { return at(film, a_s).leds[i] == at(film, b_s).leds[i]; });
}

// What users load on robots.
std::vector<std::filesystem::path> shipped_programs() {
  std::vector<std::filesystem::path> out;
  for (const char* const folder : {"scenarios", "experiments", "hal/platforms/kilobot/firmware"})
    for (const auto& file :
         std::filesystem::recursive_directory_iterator(std::filesystem::path(ARKMESH_SOURCE_DIR) / folder))
      if (file.path().extension() == ".c") out.push_back(file.path());
  std::ranges::sort(out);
  return out;
}

}  // namespace

TEST_CASE("shipped programs go on after a pause") {
  // Each shipped program, paused for 1 s and told to run: within 2 s its robots walk as far and show as many LEDs as in
  // a swarm that was not paused, and half a second later they have the colours they had before. Likewise when they were
  // asked who they are, before the pause, across its begin, or within it.
  const std::vector<std::filesystem::path> programs = shipped_programs();
  CHECK(programs.size() >= 7);
  for (const std::filesystem::path& program : programs) {
    for (const Asked& asked : {Asked{.when = "never"}, Asked{"before", 6, 7}, Asked{"across its begin", 8.5, 9.5},
                               Asked{"within", 9.2, 9.6}}) {
      INFO(program.string(), ", asked who it is: ", std::string(asked.when));
      const std::vector<Picture> paused = film(program, asked, true), twin = film(program, asked, false);
      // the program does something, and the pause stops it
      REQUIRE((speed(twin, 5, 6) > 0.002 || lit(twin, 6) > 0.2));
      CHECK(speed(paused, run_s - 0.5, run_s) < 1e-4);
      CHECK(lit(paused, run_s) == 0);
      // chance, and robots that meet others or walls
      constexpr double tolerance = 0.1;
      const double paused_m_s = speed(paused, shown_again_s, goes_on_s),
                   twin_m_s = speed(twin, shown_again_s, goes_on_s);
      CHECK(std::abs(paused_m_s - twin_m_s) <= tolerance * twin_m_s);
      CHECK(std::abs(lit(paused, goes_on_s) - lit(twin, goes_on_s)) <= tolerance);
      // colours that robots answer with are none of the program's
      const double before_s = asked.from_s > 8 && asked.from_s < pause_s ? asked.from_s : pause_s;
      CHECK(of_same_colour(paused, before_s, shown_again_s) >=
            of_same_colour(twin, before_s, shown_again_s) - tolerance);
    }
  }
}

}  // namespace arkmesh::sim_ode
