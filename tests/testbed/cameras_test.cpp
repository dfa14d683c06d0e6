// What a testbed's cameras show, and when it is believed.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "tests/support/processes/temporary_directory.hpp"
#include "tests/testbed/observed_testbed.hpp"
#include "tests/testbed/watched_emulator.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;

TEST_CASE("a camera that freezes, goes dark or is gone gives no poses") {
  // Proves that nothing is invented: looks without a picture and pictures that do not show the testbed make no frame,
  // and all of it is counted.
  const arkmesh::tests::TemporaryDirectory folder;
  EmulatedTestbed testbed(emulator_text());
  const auto monitor = testbed.monitor(lab_text(folder.path() / "testbed.yaml"), folder.path() / "testbed.yaml");
  for (int i = 0; i < 200 && !monitor->everybody_named(); ++i) testbed.next(*monitor);
  REQUIRE(monitor->everybody_named());
  monitor->latest();

  // Its noise was in every picture so far: from 0.5 s of one and the same on it hangs, though robots stand still.
  REQUIRE(monitor->counters()["camera.same_picture"] == 0);
  REQUIRE(testbed.emulator().command("camera camera0 frozen") == "ok");
  for (int i = 0; i < 5; ++i) {
    testbed.next(*monitor);
    CHECK(monitor->latest().has_value());
  }
  for (int i = 0; i < 5; ++i) {
    testbed.next(*monitor);
    CHECK_FALSE(monitor->latest().has_value());
  }
  CHECK(monitor->doubtful().size() == 8);
  CHECK(monitor->counters()["camera.frozen"] == 5);
  CHECK(monitor->counters()["camera.same_picture"] == 9);

  testbed.emulator().command("camera camera0 gone");
  testbed.next(*monitor);
  CHECK_FALSE(monitor->latest().has_value());
  CHECK(monitor->counters()["frame.no_picture"] == 6);

  testbed.emulator().command("camera camera0 ok");
  testbed.emulator().command("camera camera0 dark");
  for (int i = 0; i < 15; ++i) {
    testbed.next(*monitor);
    CHECK_FALSE(monitor->latest().has_value());
  }
  CHECK(monitor->doubtful().size() == 8);
  CHECK(monitor->counters()["camera.unrecognised"] == 1);
  CHECK(monitor->counters()["camera.refused.unrecognised"] == 15);

  testbed.emulator().command("camera camera0 ok");
  for (int i = 0; i < 250 && !monitor->everybody_named(); ++i) {
    testbed.next(*monitor);
    CHECK(testbed.wrong_ids(*monitor) == 0);
  }
  CHECK(monitor->everybody_named());
}

TEST_CASE("robots that stand before a camera without noise are seen, for as long as they are not told to run") {
  // Proves that equal pictures are new ones: robots keep age 0, nobody is in doubt, and swapping two of them meanwhile
  // would be seen. Told to run while the picture stays as it is, they are in doubt after 10 s.
  const arkmesh::tests::TemporaryDirectory folder;
  EmulatedTestbed testbed(emulator_text("noise = 0.0"));
  const auto monitor = testbed.monitor(lab_text(folder.path() / "testbed.yaml"), folder.path() / "testbed.yaml");
  for (int i = 0; i < 200 && !monitor->everybody_named(); ++i) testbed.next(*monitor);
  REQUIRE(monitor->everybody_named());
  for (int i = 0; i < 30 && monitor->question(); ++i) testbed.next(*monitor);
  REQUIRE(!monitor->question());
  monitor->latest();
  const std::uint64_t before = monitor->counters()["camera.same_picture"];
  const auto all_seen = [&] {
    testbed.next(*monitor);
    const auto frame = monitor->latest();
    return frame && frame->robots.size() == 8 && monitor->doubtful().empty() &&
           std::ranges::all_of(frame->robots, [](const hal::Observation& seen) { return seen.age.count() == 0; });
  };
  for (int i = 0; i < 150; ++i) CHECK(all_seen());
  CHECK(monitor->counters()["camera.same_picture"] - before > 140);

  monitor->robots_run(true);
  for (int i = 0; i < 100; ++i) CHECK(all_seen());
  CHECK(monitor->counters()["camera.frozen"] == 0);
  testbed.next(*monitor);
  CHECK_FALSE(monitor->latest());
  CHECK(monitor->doubtful().size() == 8);
  CHECK(monitor->counters()["camera.frozen"] == 1);
  testbed.emulator().command("robot 0 take");
  testbed.next(*monitor);
  CHECK(monitor->latest());
}

TEST_CASE("poses are as old as the pictures that show them") {
  // Proves that a camera's latency, once told, is in the age of every robot that its newest picture shows, and that
  // robots are named nevertheless.
  const arkmesh::tests::TemporaryDirectory folder;
  EmulatedTestbed testbed(emulator_text());
  testbed.late_pictures = 2;
  const auto monitor =
      testbed.monitor(lab_text(folder.path() / "testbed.yaml") + "latency_ms = 200\n", folder.path() / "testbed.yaml");
  for (int i = 0; i < 300 && !monitor->everybody_named(); ++i) testbed.next(*monitor);
  REQUIRE(monitor->everybody_named());
  for (int i = 0; i < 20; ++i) {
    testbed.next(*monitor);
    const auto frame = monitor->latest();
    REQUIRE(frame.has_value());
    CHECK(frame->robots.size() == 8);
    for (const hal::Observation& seen : frame->robots) CHECK(seen.age == hal::LabTime{200'000});
  }
}

TEST_CASE("exposure, gain and white balance of a stream are refused by name") {
  // Proves that no key is without effect: only a camera at this machine can be told.
  for (const std::string key : {"exposure_ms", "gain", "white_balance_k"}) {
    const std::string text =
        "[arena]\nwidth_m = 1\nheight_m = 1\nrobots = 1\n[[arena.kilobot.cameras]]\nsource = "
        "\"http://127.0.0.1:1/camera\"\ncalibration = \"camera.yaml\"\n" +
        key + " = 1000\n";
    CHECK_THROWS_WITH_AS(std::ignore = lab_settings(hal::Config::from_text(text, "lab.toml")),
                         doctest::Contains((key + " = 1000.0: can be set only for a camera at this machine").c_str()),
                         hal::ConfigError);
  }
}

TEST_CASE("pictures of another size than the calibration's show nobody") {
  // Proves that they make no frame, that they are counted and said, and that the next right one is used.
  const arkmesh::tests::TemporaryDirectory folder;
  EmulatedTestbed testbed(emulator_text());
  const auto monitor = testbed.monitor(lab_text(folder.path() / "testbed.yaml"), folder.path() / "testbed.yaml");
  for (int i = 0; i < 200 && !monitor->everybody_named(); ++i) testbed.next(*monitor);
  REQUIRE(monitor->everybody_named());
  monitor->latest();
  testbed.scale = 0.5;
  testbed.next(*monitor);
  CHECK_FALSE(monitor->latest());
  CHECK(monitor->doubtful().size() == 8);
  CHECK(monitor->counters()["camera.refused.size"] == 1);
  CHECK(monitor->error().find("sends pictures of 400 x 320 pixels, and its calibration is for 800 x 640") !=
        std::string::npos);
  testbed.scale = 1;
  testbed.next(*monitor);
  CHECK(monitor->latest());
  CHECK(monitor->error().empty());
}

TEST_CASE("a lab begins with a camera that was moved since it was calibrated") {
  // Proves that the first frame already has everybody in its true place, in darker light than while calibrating.
  ObservedTestbed testbed("brightness = 0.7\n");
  testbed.happen("camera camera0 move 0.01 -0.004 1.5");
  testbed.start();
  CHECK(testbed.counted("camera.moved") == 1);
  CHECK(testbed.counted("camera.realigned") == 1);
  CHECK(testbed.counted("camera.refused.unrecognised") + testbed.counted("camera.refused.moved") <= 25);
  CHECK(testbed.right() == ObservedTestbed::robots);
  testbed.steps(3, [&] { CHECK(testbed.wrong() == 0); });
  for (const hal::Observation& seen : testbed.frame.value_or(hal::PoseFrame{}).robots) {
    const auto at = testbed.truth(seen.robot);
    REQUIRE(at);
    CHECK(std::hypot(at->x_m - seen.pose.x_m, at->y_m - seen.pose.y_m) < 0.003);
  }
}
