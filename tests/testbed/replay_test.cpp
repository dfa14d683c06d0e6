// A testbed's record, played again: the words that robots heard and the poses that the lab saw.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "app/joint_run.hpp"
#include "app/testbed/testbed_replay.hpp"
#include "emulator/emulated_arena.hpp"
#include "emulator/emulator_record.hpp"
#include "emulator/said_words.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
namespace fs = std::filesystem;

namespace {

// A lab of six robots before one or two cameras of an emulated testbed, and what its record is compared with.
class RecordedRun {
 public:
  explicit RecordedRun(double seconds, int cameras = 1, const std::string& events = "") {
    folder.write("emulator.toml",
                 "[arena]\nrobots = 6\nwidth_m = 0.5\nheight_m = 0.5\n[arena.ode]\ncontroller = "
                 "\"" ARKMESH_SOURCE_DIR
                 "/scenarios/dhtf/controller/dhtf.c\"\n[[emulator.camera]]\nname = \"camera0\"\nwidth_px = 640\n"
                 "height_px = 480\nz_m = 0.95\nfocal_px = 800.0\n" +
                     (cameras == 1 ? std::string()
                                   : "[[emulator.camera]]\nname = \"camera1\"\nwidth_px = 640\nheight_px = 480\n"
                                     "x_m = 0.1\nz_m = 0.95\nlook_x_m = 0.1\nfocal_px = 800.0\n") +
                     events);
    std::string list;
    for (int i = 0; i < cameras; ++i)
      list += fmt::format("[[arena.kilobot.cameras]]\nsource = \"{}\"\ncalibration = \"testbed.yaml\"\n", i);
    const hal::Config emulator = hal::Config::from_file(folder.path() / "emulator.toml");
    emulator::write_calibration(emulator::Emulator(emulator.root()), (folder.path() / "testbed.yaml").string());
    const auto lab = folder.write(
        "roark.toml", fmt::format("[lab]\nname = \"roark\"\n[run]\nscenario = \"dhtf\"\nduration_s = {:.1f}\n"
                                  "[arena]\nuse = \"emulated\"\nrobots = 6\nwidth_m = 0.5\nheight_m = 0.5\n"
                                  "[arena.emulated]\nfile = \"emulator.toml\"\n[arena.kilobot]\n"
                                  "record = \"run/roark/raw\"\n{}[scenario.dhtf.requirements]\nroark = [1, 2]\n",
                                  seconds, list));
    app::JointRun run({hal::Config::from_file(lab)}, folder.path() / "run");
    emulator::Emulator& testbed = emulator::emulator_of(run.lab(0).arena());
    testbed.listen([this](const sim_ode::Transmission& sent) { heard.push_back(sent); });
    while (run.step()) {
    }
    finished = run.finished();
    reason = run.lab(0).runner().reason();
    for (const auto& [name, total] : run.lab(0).arena().counters().all())
      if (name.starts_with("raw.")) not_recorded += total;
  }
  fs::path lab() const { return folder.path() / "run/roark"; }
  fs::path picture(int number) const { return lab() / fmt::format("raw/camera0/{:06}.png", number); }

  tests::TemporaryDirectory folder;
  std::vector<sim_ode::Transmission> heard;  // of the emulated controller, by whoever listens at the testbed
  bool finished = false;
  std::string reason;
  std::uint64_t not_recorded = 0;
};

std::vector<sim_ode::Transmission> said_again(const fs::path& serial, bool loses_power = true) {
  std::ifstream in(serial);
  testbed::SerialLines lines(in, serial.string());
  std::vector<sim_ode::Transmission> out;
  emulator::replay_serial_line(lines, loses_power, [&](const sim_ode::Transmission& sent) { out.push_back(sent); });
  return out;
}

app::PoseComparison compare(const fs::path& folder) {
  return app::compare_poses(app::find_testbed_record(folder), hal::nobody_stops());
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// Whether a replay of that folder ends in a sentence with `part`; where that is empty, in none.
bool complains(const fs::path& folder, const std::string& part) {
  std::string said;
  try {
    const app::TestbedRecord record = app::find_testbed_record(folder);
    app::replay_words(record, hal::nobody_stops(), [](const app::SaidWord&) {});
    app::compare_poses(record, hal::nobody_stops());
  } catch (const std::exception& wrong) {
    said = wrong.what();
  }
  CAPTURE(said);
  CHECK(said.empty() == part.empty());
  CHECK(said.find('\n') == std::string::npos);
  return holds(said, part);
}

}  // namespace

TEST_CASE("replay: a lab's run gives the same words and poses again") {
  // Proves that the recorded bytes make an overhead controller say what the emulated one said in the run, message by
  // message, and that the recorded pictures give every pose of the log to the last bit; that a picture which is another
  // one is noticed, and that the comparison ends at one that is not there.
  const RecordedRun run(12);
  CAPTURE(run.reason);
  REQUIRE(run.finished);
  CHECK(run.not_recorded == 0);

  const auto again = said_again(run.lab() / "raw/serial.txt");
  // Who listens in the run hears at the robots' next tick: the very last messages are in the replay only.
  REQUIRE(run.heard.size() > 300);
  REQUIRE(again.size() >= run.heard.size());
  CHECK(again.size() - run.heard.size() <= 3);
  std::size_t others = 0;
  for (std::size_t i = 0; i < run.heard.size(); ++i)
    others += run.heard[i].start_us != again[i].start_us || run.heard[i].end_us != again[i].end_us ||
              run.heard[i].message != again[i].message || run.heard[i].clean != again[i].clean;
  CHECK(others == 0);

  const app::PoseComparison same = compare(run.lab());
  CAPTURE(same.first_difference);
  CHECK(same.frames == 121);  // 12 s of ten frames a second, and frame 0
  CHECK(same.poses > 600);    // of six robots
  CHECK(same.different == 0);
  CHECK(same.most_m == 0);
  CHECK(same.most_rad == 0);
  CHECK(same.ended_by.empty());
  CHECK(same.same());

  // Somewhere in the run another picture: everything is turned about.
  const int number = 130;
  REQUIRE(fs::exists(run.picture(number)));
  cv::Mat turned;
  cv::flip(cv::imread(run.picture(number).string()), turned, -1);
  cv::imwrite(run.picture(number).string(), turned);
  const app::PoseComparison changed = compare(run.lab());
  CHECK(changed.different > 0);
  CHECK_FALSE(changed.same());
  CHECK(holds(changed.first_difference, "frame "));

  fs::remove(run.picture(number));
  const app::PoseComparison shorter = compare(run.lab());
  CHECK(shorter.frames < same.frames);
  CHECK(shorter.frames > 20);
  CHECK(shorter.different == 0);
  CHECK(holds(shorter.ended_by, "000130.png is missing or damaged"));

  // A log of which nothing is left.
  std::ofstream(run.lab() / "log.lcm", std::ios::trunc).flush();
  CHECK(complains(run.lab(), "log.lcm"));
}

TEST_CASE("replay: two cameras, of which one goes, and a controller that loses its power") {
  // Proves that a record across such troubles holds when the port was lost and why, that the words before it are those
  // of the run, and that the poses are the same with both cameras, with one, and while the controller is gone.
  const RecordedRun run(12, 2,
                        "[[emulator.event]]\nat_s = 8.0\ndo = \"camera camera1 gone\"\n[[emulator.event]]\nat_s = "
                        "9.0\ndo = \"ohc unplug\"\n[[emulator.event]]\nat_s = 10.0\ndo = \"ohc plug\"\n");
  CAPTURE(run.reason);
  REQUIRE(run.finished);
  const std::string serial = tests::read_file(run.lab() / "raw/serial.txt");
  CHECK(holds(serial, " closed the emulator's overhead controller is unplugged\n"));
  const std::string looks = tests::read_file(run.lab() / "raw/looks.txt");
  CHECK(holds(looks, ".png@7900000 000"));
  CHECK(holds(looks, ".png@8100000 -\n"));
  const auto again = said_again(run.lab() / "raw/serial.txt");
  const auto before = [](const sim_ode::Transmission& sent) { return sent.end_us < 9'000'000; };
  const auto count = static_cast<std::size_t>(std::ranges::count_if(run.heard, before));
  REQUIRE(count > 100);
  REQUIRE(again.size() > count);
  for (std::size_t i = 0; i < count; ++i) CHECK(run.heard[i].message == again[i].message);
  const app::PoseComparison poses = compare(run.lab());
  CAPTURE(poses.first_difference);
  CHECK(poses.frames > 100);
  CHECK(poses.different == 0);
  CHECK(poses.most_m == 0);
}

TEST_CASE("replay: folders that are no records end in one sentence") {
  // Proves that a folder without a record, and one whose parts are missing, damaged or of somebody else, is refused
  // with the file; the record of a set-up procedure has words only.
  const tests::TemporaryDirectory folder;
  CHECK(complains(folder.path(), "is not a testbed record"));
  folder.write("raw/serial.txt", "# arkmesh serial line 1\n5 open\n");
  CHECK(complains(folder.path(), "facts.json is missing, damaged, or of another version"));
  for (const char* wrong : {"", "[]", "{", R"({"record": 2})", R"({"record": {}})"}) {
    folder.write("raw/facts.json", wrong);
    CHECK(complains(folder.path(), "facts.json is missing, damaged"));
  }
  folder.write("raw/facts.json", R"({"record": 1, "arena": "kilobot"})");
  CHECK(complains(folder.path(), ""));
  CHECK(holds(compare(folder.path()).not_compared, "does not come from a lab's run"));

  folder.write("log.lcm", "");
  for (const char* wrong : {"", "[arena", "[arena]\nrobots = 2\n"}) {
    folder.write("config.toml", wrong);
    CHECK(complains(folder.path(), "config.toml"));
  }
  folder.write("raw/serial.txt", "# arkmesh serial line 1\n5 open\n4 end\n");
  CHECK(complains(folder.path(), "serial.txt:3: this line has an earlier time"));
}

TEST_CASE("replay: messages in words") {
  // Proves that commands, composites and calibrations are told as people know them.
  using hal::kilobot::Message;
  CHECK(emulator::in_words(Message{{}, hal::kilobot::type_run, 0}, hal::kilobot::ark_layout) == "run");
  CHECK(emulator::in_words(Message{{}, hal::kilobot::type_wakeup, 0}, hal::kilobot::ark_layout) == "pause");
  // robots 5 and 1000, and a filler; set id 300
  CHECK(emulator::in_words(Message{{0x01, 0x45, 0x2C, 0xFA, 0x3B, 0xFF, 0xFF, 0xC0, 0x00}, 0, 0},
                           hal::kilobot::ark_layout) == "to 5: kind 1 value 300, to 1000: kind 14 value 1023");
  CHECK(emulator::in_words(Message{{1, 0x2C, 1}, hal::kilobot::type_calibrate, 0}, hal::kilobot::ark_layout) ==
        "set id 300");
  CHECK(emulator::in_words(Message{{7, 6}, hal::kilobot::type_boot_page, 0}, hal::kilobot::ark_layout) ==
        "flash page 7, from word 6");
  CHECK(emulator::in_words(Message{{1, 2}, 55, 0}, hal::kilobot::ark_layout) == "type 55: 01 02 00 00 00 00 00 00 00");
}
