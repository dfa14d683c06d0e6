// A lab that fails among others in one process: nobody's results are lost.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "app/joint_run.hpp"
#include "app/lab_files.hpp"
#include "tests/support/labs/dhtf_configs.hpp"
#include "tests/support/processes/process.hpp"

using namespace arkmesh;

TEST_CASE("a robot's program that crashes in mid-run leaves the results of all labs") {
  // Robot 3 of roark writes to a null pointer after two seconds of lab time.
  const tests::TemporaryFolder folder;
  app::LabFiles labs{.sets = {"gate.period_s=0.5",
                              "roark:arena.ode.controller=\"" ARKMESH_SOURCE_DIR "/tests/programs/crash_null.c\""}};
  for (const char* lab : {"roark.toml", "shark.toml"})
    labs.files.push_back((tests::experiments() / "dhtf" / lab).string());
  app::JointRun run(app::read_labs(labs, 1), folder.path());
  const nlohmann::json joint = run.run(hal::nobody_stops(), nullptr);
  CHECK_FALSE(run.finished());
  const auto result = [&](const std::string& lab) {
    return nlohmann::json::parse(tests::read_file(folder.path() / lab / "result.json"));
  };
  const std::string roark = result("roark").at("ended"), shark = result("shark").at("ended");
  CHECK(roark.starts_with("roark failed at period 3: the program of robot 3 crashed: bad pointer"));
  CHECK(shark == "roark is gone at period 3: failed: " + roark);
  CHECK(result("shark").at("periods") == 3);
  CHECK(tests::read_file(folder.path() / "hash.csv").find("\n3,") != std::string::npos);
  CHECK(joint.at("final_hash") != "0000000000000000");
}
