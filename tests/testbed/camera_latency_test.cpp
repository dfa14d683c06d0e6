// The measured latency of cameras, on an emulated testbed with the truth beside it.
#include "testbed/camera_latency.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "app/testbed/set_up.hpp"
#include "emulator/emulated_arena.hpp"
#include "emulator/emulator_record.hpp"
#include "hal/stop_request.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;

namespace {

using std::chrono::milliseconds;

struct NoProgress final : hal::Progress {
  void show(const std::string&) override {}
  void show(std::uint32_t, std::uint32_t, double, const std::string&) override {}
  void done() override {}
  void say(const std::string&) override {}
};

std::string late_emulator_text() {
  return "[arena]\nrobots = 4\nwidth_m = 0.5\nheight_m = 0.5\n[arena.ode]\ncontroller = \"" ARKMESH_SOURCE_DIR
         "/scenarios/dhtf/controller/dhtf.c\"\n[[emulator.camera]]\nname = \"camera0\"\nwidth_px = 640\nheight_px "
         "= 480\nz_m = 0.95\nfocal_px = 800.0\nlatency_s = 0.15\n";
}

}  // namespace

TEST_CASE("a latency is what most flashes allow") {
  // Proves the bounds, and that a flash that contradicts the others moves nothing.
  CHECK(testbed::latency_of({}).flashes == 0);
  const auto of = [](int least, int most) { return testbed::FlashSeen{milliseconds(least), milliseconds(most)}; };
  const testbed::CameraLatency found = testbed::latency_of({of(90, 190), of(60, 152), of(148, 250), of(400, 500)});
  CHECK(found.latency_ms == doctest::Approx(150));
  CHECK(found.within_ms == doctest::Approx(2));
  CHECK(found.agree == 3);
  CHECK(found.flashes == 4);
}

TEST_CASE("poses have the time of their pictures once a camera's latency has been measured") {
  // Proves that flashes find a latency of 150 ms to 2 ms, and that with it each robot's age leads back to a moment at
  // which the camera took a picture.
  const tests::TemporaryDirectory folder;
  const auto calibration = folder.path() / "testbed.yaml";
  const auto emulated = folder.write("emulator.toml", late_emulator_text());
  const emulator::Emulator first(hal::Config::from_file(emulated, {}).root());
  emulator::write_calibration(first, calibration.string());
  const std::string lab = fmt::format(
      "[lab]\nname = \"roark\"\n[run]\nscenario = \"dhtf\"\n[shared]\nlabs = [\"roark\"]\n[arena]\nuse = "
      "\"emulated\"\nrobots = 4\nwidth_m = 0.5\nheight_m = 0.5\nemulated.file = "
      "\"{}\"\n[[arena.kilobot.cameras]]\nsource = \"0\"\ncalibration = \"{}\"\n",
      emulated.string(), calibration.string());
  NoProgress progress;
  testbed::SetUpArena set_up =
      app::make_set_up_arena(folder.write("lab.toml", lab).string(), {}, "", hal::nobody_stops());
  const auto measured = testbed::measure_latency(set_up, 64, hal::nobody_stops(), progress);
  REQUIRE(measured.size() == 1);
  CAPTURE(measured[0].latency_ms);
  CAPTURE(measured[0].within_ms);
  CHECK(std::abs(measured[0].latency_ms - 150) < 2);
  CHECK(measured[0].agree == 64);

  const auto config =
      hal::Config::from_text(lab + fmt::format("latency_ms = {:.1f}\n", measured[0].latency_ms), "lab.toml");
  const auto arena = emulator::make_emulated_arena(config.root().section("arena"), "roark", 1, {});
  hal::advance(*arena, hal::LabTime{0});
  arena->robots().command({.kind = hal::FleetCommand::Kind::run});
  const emulator::Emulator& truth = emulator::emulator_of(*arena);
  const auto period = static_cast<double>(truth.config().frame_period.count());
  int seen = 0;
  for (int i = 1; i <= 50; ++i) {
    hal::advance(*arena, i * arena->info().frame_period);
    const auto frame = arena->poses().latest();
    if (!frame) continue;
    for (const hal::Observation& robot : frame->robots) {
      if (robot.age > milliseconds(300)) continue;
      const auto taken = static_cast<double>((truth.now() - robot.age).count());
      CHECK(std::abs(std::remainder(taken, period)) < 2000);
      ++seen;
    }
  }
  CHECK(seen > 150);
}
