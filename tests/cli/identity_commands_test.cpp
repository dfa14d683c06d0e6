// The set-up procedures before an experiment as a user meets them: `arkmesh identify`, `assign-ids` and
// `calibrate-motors`.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/support/processes/process.hpp"

using namespace arkmesh;
using tests::Process, tests::TemporaryFolder;

namespace {

struct CommandEnd {
  int code = -1;
  std::string output;  // standard output and error
};

// A lab of its own folder, and commands on it.
class Lab {
 public:
  explicit Lab(int robots, const std::string& controller = "scenarios/dhtf/controller/dhtf.c",
               const std::string& more = "") {
    std::ofstream(folder_.path() / "lab.toml") << fmt::format(
        "[lab]\nname = \"roark\"\n[run]\nscenario = \"dhtf\"\nduration_s = 60.0\n[shared]\nlabs = "
        "[\"roark\"]\n[arena]\nrobots = {}\nwidth_m = 1.2\nheight_m = 1.2\n"
        "[arena.ode]\ncontroller = \"{}/{}\"\n{}\n",
        robots, ARKMESH_SOURCE_DIR, controller, more);
  }
  CommandEnd run(std::vector<std::string> arguments, int seconds = 120) {
    arguments.insert(arguments.begin() + 1, (folder_.path() / "lab.toml").string());
    Process process(ARKMESH_PROGRAM, arguments, folder_.path() / fmt::format("output-{}.txt", ++number_));
    const auto code = process.wait(std::chrono::seconds(seconds));
    return {code.value_or(-1), process.output()};
  }

 private:
  TemporaryFolder folder_;
  int number_ = 0;
};

bool says(const CommandEnd& end, const std::string& part) {
  return end.output.find(part) != std::string::npos;
}

// Rows of the table: lines that begin with a number.
int rows(const CommandEnd& end) {
  std::istringstream lines(end.output);
  int n = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto at = line.find_first_not_of(' ');
    n += line.starts_with("  ") && at != std::string::npos && std::isdigit(static_cast<unsigned char>(line[at]));
  }
  return n;
}

}  // namespace

TEST_CASE("identify tells who is who") {
  // Twelve robots of a lab, by both protocols and with nobody expected: a row each, exit code 0.
  Lab lab(12);
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"identify"},
                                             {"identify", "--protocol", "ark"},
                                             {"identify", "--protocol", "ark-runtime"},
                                             {"identify", "--any"}}) {
    const CommandEnd end = lab.run(arguments);
    INFO(end.output);
    CHECK(end.code == 0);
    CHECK(rows(end) == 12);
    CHECK(says(end, "12 of 12 robots named"));
    CHECK(says(end, "The robots are simulated"));
  }
}

TEST_CASE("identify names those who are missing") {
  // Of twelve robots two more are expected than there are: exit code 1, and both are named; a program that cannot
  // answer finds nobody.
  Lab lab(12);
  const CommandEnd missing = lab.run({"identify", "--ids", "0-13"});
  INFO(missing.output);
  CHECK(missing.code == 1);
  CHECK(rows(missing) == 12);
  CHECK(says(missing, "not found: 12, 13"));
  const CommandEnd strangers = lab.run({"identify", "--ids", "0-9"});
  CHECK(strangers.code == 0);
  Lab mute(3, "tests/sim_ode/controllers/wander.c");
  const CommandEnd nobody = mute.run({"identify"});
  INFO(nobody.output);
  CHECK(nobody.code == 1);
  CHECK(rows(nobody) == 0);
  CHECK(says(nobody, "not found: 0-2"));
  CHECK(says(nobody, "unnamed"));
}

TEST_CASE("assign-ids gives ids") {
  // Six robots get the ids asked for; with too few ids those who got none are told of, exit code 1.
  Lab lab(6);
  const CommandEnd all = lab.run({"assign-ids", "--ids", "100-104,7"});
  INFO(all.output);
  CHECK(all.code == 0);
  CHECK(rows(all) == 6);
  CHECK(says(all, "6 of 6 robots have ids of their own"));
  const CommandEnd few = lab.run({"assign-ids", "--ids", "3,1"});
  INFO(few.output);
  CHECK(few.code == 1);
  CHECK(says(few, "2 of 6 robots have ids of their own"));
  CHECK(says(few, "no id left"));
}

TEST_CASE("calibrate-motors calibrates") {
  // Four robots, each with a row of duties and measures, stored; one that is not there is missed.
  Lab lab(4);
  const CommandEnd all = lab.run({"calibrate-motors"});
  INFO(all.output);
  CHECK(all.code == 0);
  CHECK(rows(all) == 4);
  CHECK(says(all, "4 of 4 robots calibrated and stored"));
  const CommandEnd missing = lab.run({"calibrate-motors", "--ids", "0,9"});
  INFO(missing.output);
  CHECK(missing.code == 1);
  CHECK(says(missing, "not found: 9"));
  CHECK(says(missing, "1 of 2 robots calibrated"));
}

TEST_CASE("the set-up procedures refuse wrong use") {
  // Exit code 2 and one sentence for lists that are none, ids that cannot be, arenas without robots.
  Lab lab(3);
  const std::vector<std::vector<std::string>> wrong = {{"identify", "--ids", "3-1"},
                                                       {"identify", "--ids", "1,1"},
                                                       {"identify", "--ids", "0-70000"},
                                                       {"identify", "--ids", "a"},
                                                       {"identify", "--ids", "1,"},
                                                       {"identify", "--ids", "-3"},
                                                       {"identify", "--protocol", "x"},
                                                       {"identify", "--any", "--ids", "1"},
                                                       {"assign-ids", "--ids", "5-"},
                                                       {"calibrate-motors", "--duty", "300"},
                                                       {"calibrate-motors", "--ids", "0-300"},
                                                       {"identify", "--set", "arena.use=null"}};
  for (const auto& arguments : wrong) {
    const CommandEnd end = lab.run(arguments);
    INFO(end.output);
    CHECK(end.code == 2);
    CHECK_FALSE(end.output.empty());
  }
}
