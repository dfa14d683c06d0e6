// Run folders: nobody's is overwritten, and its result.json says at any moment how the run stands.
#include "lab/run_folder.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "hal/files/replace_file.hpp"
#include "hal/record/result_file.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;

namespace {

std::string text_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

nlohmann::json result_in(const std::filesystem::path& folder) {
  return nlohmann::json::parse(text_in(folder / "result.json"), nullptr, false);
}

nlohmann::json facts() {
  return {{"labs", {"shark"}}, {"process", hal::own_process()}};
}

// A process id that is nobody's.
int gone() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  int status = 0;
  ::waitpid(child, &status, 0);
  return child;
}

}  // namespace

TEST_CASE("a folder that holds something is refused, or moved aside by force") {
  tests::TemporaryDirectory root;
  const auto folder = root.path() / "run";
  lab::claim_run_folder(folder, false);
  lab::claim_run_folder(folder, false);  // empty as it is
  std::ofstream(folder / "notes.txt") << "mine";
  CHECK_THROWS_WITH_AS(
      lab::claim_run_folder(folder, false),
      (folder.string() + " is not empty; give another folder with --out, or --force to move it aside").c_str(),
      hal::ConfigError);
  for (const char* aside : {"run.1", "run.2"}) {
    lab::claim_run_folder(folder / "", true);
    CHECK(text_in(root.path() / aside / "notes.txt") == "mine");
    CHECK(std::filesystem::is_empty(folder));
    std::ofstream(folder / "notes.txt") << "mine";
  }
}

TEST_CASE("a run that goes on keeps its folder, also by force, and says so in result.json") {
  tests::TemporaryDirectory root;
  const auto folder = root.path() / "run";
  lab::claim_run_folder(folder, false);
  {
    const lab::RunFolder run(folder, "", {}, facts());
    CHECK(result_in(folder).at("state") == "running");
    CHECK_THROWS_AS(lab::claim_run_folder(folder, true), hal::ConfigError);
    CHECK_THROWS_AS(lab::RunFolder(folder, "", {}, facts()), hal::ConfigError);
    run.save_result({{"state", "finished"}});
  }
  CHECK(result_in(folder).at("state") == "finished");
  CHECK_FALSE(std::filesystem::exists(folder / "reserve.tmp"));
  lab::claim_run_folder(folder, true);
}

TEST_CASE("a run that cannot say what it is does not begin, and leaves nothing") {
  tests::TemporaryDirectory root;
  for (const char* file : {"config.toml", "result.json"}) {
    const auto folder = root.path() / file;
    std::filesystem::create_directories(hal::part_of(folder / file));  // in the way
    CHECK_THROWS_WITH_AS(
        lab::RunFolder(folder, "", {}, facts()),
        ("cannot record in " + folder.string() +
         ": File exists; make room there (recorder.keep_free_mib = 64 stays free), or choose another directory "
         "with --out")
            .c_str(),
        std::runtime_error);
    CHECK(std::distance(std::filesystem::directory_iterator(folder), {}) == 1);
  }
}

TEST_CASE("the next start marks a run whose process is gone as killed") {
  tests::TemporaryDirectory root;
  nlohmann::json left = {{"state", "running"}, {"labs", {"shark"}}, {"process", hal::own_process()}};
  for (const char* lives : {"lives", "lives/shark"}) {
    std::filesystem::create_directories(root.path() / lives);
    hal::save_json(root.path() / lives / "result.json", left);
  }
  nlohmann::json reused = left;  // by this process, which began at another time
  reused["process"]["began_ticks"] = 1;
  std::filesystem::create_directories(root.path() / "reused");
  hal::save_json(root.path() / "reused" / "result.json", reused);
  std::filesystem::create_directories(root.path() / "pipe");
  REQUIRE(::mkfifo((root.path() / "pipe" / "result.json").c_str(), 0600) == 0);  // nobody ever writes to it
  left["process"]["pid"] = gone();
  for (const char* dead : {"dead", "dead/shark"}) {
    std::filesystem::create_directories(root.path() / dead);
    hal::save_json(root.path() / dead / "result.json", left);
  }
  hal::save_json(root.path() / "result.json", {{"state", 3}});  // somebody else's
  lab::claim_run_folder(root.path() / "next", false);
  CHECK(result_in(root.path() / "dead").at("state") == "killed");
  CHECK(result_in(root.path() / "dead" / "shark").at("state") == "killed");
  CHECK(result_in(root.path() / "reused").at("state") == "killed");
  CHECK(result_in(root.path() / "lives").at("state") == "running");
  CHECK(result_in(root.path() / "lives" / "shark").at("state") == "running");
}
