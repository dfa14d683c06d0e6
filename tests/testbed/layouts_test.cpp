// Robots' programs written for other layouts do their task in simulation and on an emulated testbed, told the same.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <array>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "emulator/emulated_arena.hpp"
#include "emulator/said_words.hpp"
#include "hal/overlay/led_name.hpp"
#include "hal/platforms/kilobot/message_registers.hpp"
#include "sim_ode/ode_arena.hpp"
#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::tests {
namespace {

using hal::Led;

constexpr int robots = 6;

// An arena whose robots run that program, with a line for [arena.kilobot].
class LayoutBench {
 public:
  LayoutBench(bool emulated, const std::string& program, const std::string& kilobot) {
    const std::string arena = fmt::format("[arena]\nrobots = {}\nwidth_m = 0.5\nheight_m = 0.5\n", robots);
    const std::string ode =
        fmt::format("[arena.ode]\ncontroller = \"{}/tests/programs/{}.c\"\n", ARKMESH_SOURCE_DIR, program);
    if (!emulated) {
      arena_ = sim_ode::ode_arena_row().make(section(fmt::format("{}{}[arena.kilobot]\n{}\n", arena, ode, kilobot)),
                                             {.lab = "lab"});
      return;
    }
    const auto file = directory_.path() / "emulator.toml", calibration = directory_.path() / "testbed.yaml";
    const std::string text =
        arena + ode +
        "[[emulator.camera]]\nname = \"camera0\"\nwidth_px = 640\nheight_px = 480\nz_m = 0.95\nfocal_px = 800.0\n";
    std::ofstream(file) << text;
    emulator::write_calibration(emulator::Emulator(hal::Config::from_text(text, "emulator.toml").root()), calibration);
    arena_ = emulator::make_emulated_arena(
        section(fmt::format("{}emulated.file = \"{}\"\n[arena.kilobot]\nidentity = \"ark\"\n{}\n"
                            "[[arena.kilobot.cameras]]\nsource = \"0\"\ncalibration = \"{}\"\n",
                            arena, file.string(), kilobot, calibration.string())),
        "lab", 1, {});
  }

  hal::Arena& arena() { return *arena_; }
  void start() {
    hal::advance(*arena_, hal::LabTime{0});
    arena_->robots().command({hal::FleetCommand::Kind::run});
  }
  // What LEDs show after so many frames, each of which says `words` again.
  std::vector<Led> shown_after(int frames, const std::vector<hal::ToRobot>& words) {
    std::vector<Led> out;
    for (int n = 0; n < frames; ++n) {
      arena_->robots().offer(words);
      now_ += arena_->info().frame_period;
      hal::advance(*arena_, now_);
      if (const auto frame = arena_->poses().latest()) {
        out.clear();
        for (const hal::Observation& seen : frame->robots) out.push_back(seen.led);
      }
    }
    return out;
  }

 private:
  static hal::Section section(const std::string& text) {
    return hal::Config::from_text(text, "lab.toml").root().section("arena");
  }
  TemporaryDirectory directory_;
  std::unique_ptr<hal::Arena> arena_;
  hal::LabTime now_{0};
};

std::string in_words(const std::vector<Led>& shown) {
  std::string out;
  for (const Led led : shown) out += fmt::format(" {}", hal::name_of(led));
  return out;
}

// "5:1:300" or "10:008000000001000002", as the table of layouts has them.
hal::ToRobot told(const std::string& text) {
  const auto colon = text.find(':'), second = text.find(':', colon + 1);
  if (second != std::string::npos)
    return {.robot = static_cast<hal::RobotId>(std::stoul(text)),
            .kind = static_cast<std::uint8_t>(std::stoul(text.substr(colon + 1))),
            .value = static_cast<std::uint32_t>(std::stoul(text.substr(second + 1)))};
  hal::WholeMessage whole{static_cast<std::uint8_t>(std::stoul(text)), {}};
  for (std::size_t i = 0; i < whole.data.size(); ++i)
    whole.data[i] = static_cast<std::uint8_t>(std::stoul(text.substr(colon + 1 + 2 * i, 2), nullptr, 16));
  return {.robot = hal::everyone, .whole = whole};
}

std::string in_hex(const hal::kilobot::Message& message) {
  std::string out = fmt::format("{}", message.type);
  for (std::size_t i = 0; i < message.data.size(); ++i)
    out += fmt::format("{}{:02x}", i % 3 == 0 ? " " : "", message.data[i]);
  return out;
}

// The words of one round, and what each robot shows then.
struct Round {
  std::vector<hal::ToRobot> words;
  std::vector<Led> shown;
};

void check_rounds(LayoutBench& bench, const std::vector<Round>& rounds) {
  for (const Round& round : rounds) CHECK(in_words(bench.shown_after(30, round.words)) == in_words(round.shown));
  const hal::Airtime air = bench.arena().robots().airtime();
  CHECK(air.refused == 0);
  CHECK(air.offered == air.sent + air.replaced + air.refused + air.not_sent + air.waiting);
}

}  // namespace

TEST_CASE("layouts: rows of the table") {
  // What registers send is what was worked out by hand, a record of it reads as it was said, and programs understand
  // it.
  std::ifstream table(ARKMESH_SOURCE_DIR "/tests/sim_ode/host/layout_table.txt");
  int rows = 0;
  for (std::string line; std::getline(table, line);) {
    if (line.empty() || line[0] == '#') continue;
    ++rows;
    CAPTURE(line);
    std::vector<std::string> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, '|');) {
      const auto from = cell.find_first_not_of(' '), to = cell.find_last_not_of(' ');
      row.push_back(cell.substr(from, to - from + 1));
    }
    REQUIRE(row.size() == 6);
    const std::string folder = row[1] == "light_up" ? "experiments/light_up" : "tests/programs";
    hal::Config config = hal::Config::from_text(
        fmt::format("[arena]\nrobots = 127\nwidth_m = 3.0\nheight_m = 3.0\n[arena.kilobot]\nlayout = \"{}\"\n"
                    "[arena.ode]\ncontroller = \"{}/{}/{}.c\"\n",
                    row[0], ARKMESH_SOURCE_DIR, folder, row[1]),
        "lab.toml");
    const auto arena = sim_ode::ode_arena_row().make(config.root().section("arena"), {.lab = "lab"});
    std::vector<hal::ToRobot> said;
    std::istringstream words(row[3]);
    for (std::string word; words >> word;) said.push_back(told(word));
    hal::Counters counters;
    hal::kilobot::MessageRegisters registers(arena->info(), counters);
    registers.offer(said);
    const auto outgoing = registers.next();
    REQUIRE(outgoing);
    CHECK(in_hex(outgoing->message) == row[4]);
    const auto layout = hal::kilobot::layout_of(arena->info());
    const std::string read = emulator::in_words(outgoing->message, layout);
    for (const hal::ToRobot& word : said) {
      if (word.whole) continue;
      const std::string kind = layout.kind_bits > 0 ? fmt::format("kind {} ", word.kind) : "";
      CHECK(read.find(fmt::format("to {}: {}value {}", word.robot, kind, word.value)) != std::string::npos);
    }

    hal::advance(*arena, hal::LabTime{0});
    if (row[2] != "-") {
      const hal::WholeMessage before = *told(row[2]).whole;
      arena->robots().command({hal::FleetCommand::Kind::broadcast, before.type, before.data});
    }
    arena->robots().command({hal::FleetCommand::Kind::run});
    hal::advance(*arena, hal::LabTime{500'000});
    arena->robots().offer(said);
    hal::advance(*arena, hal::LabTime{1'000'000});
    CHECK(std::string(hal::name_of(arena->poses().latest()->robots.at(5).led)) == row[5]);
  }
  CHECK(rows == 9);
}

TEST_CASE("layouts: 8 + 16 bits, a place and a heading") {
  for (const bool emulated : {false, true}) {
    CAPTURE(emulated);
    LayoutBench bench(emulated, "layout_8_16", "layout = \"8+16\"");
    CHECK(bench.arena().info().max_robot == 254);
    bench.start();
    // 1 bit of kind, 5 of x, 5 of y, 5 of heading; robots with odd ids are in the east, then the others
    std::array<Round, 2> rounds;
    for (std::size_t n = 0; n < 2; ++n)
      for (std::uint32_t id = 0; id < robots; ++id) {
        const bool east = (id + n) % 2 == 1;
        rounds[n].words.push_back({.robot = id, .value = (east ? 16 + id : 15 - id) << 10 | 31 << 5 | id});
        rounds[n].shown.push_back(east ? Led::green : Led::blue);
      }
    check_rounds(bench, {rounds.begin(), rounds.end()});
  }
}

TEST_CASE("layouts: 7 + 17 bits, three levels and a quadrant") {
  for (const bool emulated : {false, true}) {
    CAPTURE(emulated);
    LayoutBench bench(emulated, "layout_7_17", "layout = \"7+17\"");
    CHECK(bench.arena().info().max_robot == 126);
    bench.start();
    Round round;
    for (std::uint32_t id = 0; id < robots; ++id) {
      std::array<std::uint32_t, 3> levels{31, 31, 31};
      levels[id % 3] = id;
      round.words.push_back({.robot = id, .value = levels[0] << 12 | levels[1] << 7 | levels[2] << 2 | 3});
      round.shown.push_back(std::array{Led::red, Led::green, Led::blue}[id % 3]);
    }
    check_rounds(bench, {round});
  }
}

TEST_CASE("layouts: 7 + 1 + 16 bits, after a message with start parameters") {
  for (const bool emulated : {false, true}) {
    CAPTURE(emulated);
    LayoutBench bench(emulated, "layout_7_1_16", "layout = \"7+1+16\"");
    bench.start();
    bench.arena().robots().command(
        {.kind = hal::FleetCommand::Kind::broadcast, .type = 10, .data = hal::in_three_groups({0x8000, 1, 2})});
    Round round;
    for (std::uint32_t id = 0; id < robots; ++id) {
      const std::uint32_t quality = id % 2 == 0 ? 0x7FFF : 0x8001;
      round.words.push_back({.robot = id, .slot = 0, .kind = 1, .value = quality});
      round.words.push_back({.robot = id, .slot = 1, .kind = 0, .value = 65'535});
      round.shown.push_back(id % 2 == 0 ? Led::red : Led::green);
    }
    check_rounds(bench, {round});
  }
}

TEST_CASE("layouts: whole messages reach all robots everywhere, and one robot in simulation only") {
  // The floor's colour in bits 1 to 3 of the third byte; the last six count up.
  const auto floor = [](hal::RobotId robot, std::uint8_t colour) {
    const auto byte = static_cast<std::uint8_t>(colour << 1);
    return hal::ToRobot{.robot = robot, .whole = hal::WholeMessage{20, {0xFC, 0xF0, byte, 7, 8, 9, 10, 11, 12}}};
  };
  for (const bool emulated : {false, true}) {
    CAPTURE(emulated);
    LayoutBench bench(emulated, "layout_whole", "");
    bench.start();
    // words beside it, which this program does not know
    std::vector<hal::ToRobot> said{floor(hal::everyone, 4)};
    for (std::uint32_t id = 0; id < robots; ++id) said.push_back({id, 0, 1, 1023});
    check_rounds(bench, {{said, std::vector<Led>(robots, Led::blue)},
                         {{floor(hal::everyone, 1)}, std::vector<Led>(robots, Led::red)}});
    std::vector<Led> shown(robots, Led::red);
    if (!emulated) shown[3] = Led::green;
    CHECK(in_words(bench.shown_after(10, {floor(3, 2)})) == in_words(shown));
    CHECK(bench.arena().counters()["to_robots.refused.whole_to_one"] == (emulated ? 10 : 0));
  }
}

}  // namespace arkmesh::tests
