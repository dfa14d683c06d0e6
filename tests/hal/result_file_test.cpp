// result.json: its outcome comes back as it was written, whether the run goes on follows one rule, and files of
// somebody else are no results.
#include "hal/record/result_file.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>

#include "hal/files/replace_file.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
using hal::Outcome;
using hal::ResultFile;
using nlohmann::json;

namespace {

// What a folder with this result.json says.
struct Told {
  explicit Told(const std::string& text) { folder.write("result.json", text); }
  ResultFile file() const { return ResultFile(folder.path()); }
  tests::TemporaryDirectory folder;
};

std::string running(const json& process) {
  return json{{"state", "running"}, {"labs", {"shark"}}, {"process", process}}.dump();
}

json own_with(const char* key, const json& value) {
  json process = hal::own_process();
  process[key] = value;
  return process;
}

}  // namespace

TEST_CASE("each outcome is written as its word, and read again") {
  const std::pair<Outcome, const char*> words[] = {{Outcome::running, "running"},
                                                   {Outcome::finished, "finished"},
                                                   {Outcome::stopped, "stopped"},
                                                   {Outcome::failed, "failed"},
                                                   {Outcome::killed, "killed"}};
  for (const auto& each : words) {
    json result;
    hal::set_outcome(result, each.first);
    CHECK(result == json{{"state", each.second}, {"ended", each.second}});
    CHECK(hal::outcome_in(result) == each.first);
    hal::set_outcome(result, each.first, "roark is gone");
    CHECK(hal::ended_in(result) == "roark is gone");
  }
}

TEST_CASE("what somebody else wrote says no outcome, and nothing fails") {
  for (const char* text : {"", "[[[", "[1]", "7", "null", R"({"state": 5})", R"({"state": "dancing", "ended": 7})",
                           R"({"state": ["running"], "process": 3, "labs": "shark"})"}) {
    CAPTURE(text);
    const Told told(text);
    CHECK_FALSE(told.file().outcome().has_value());
    CHECK(told.file().ended().empty());
    CHECK(told.file().runs() == ResultFile::Runs::no);
    CHECK(told.file().goes_on_in_words().empty());
    CHECK_FALSE(told.file().mark_killed());
    CHECK(tests::read_file(told.folder.path() / "result.json") == text);
  }
  const tests::TemporaryDirectory pipe;
  REQUIRE(::mkfifo((pipe.path() / "result.json").c_str(), 0600) == 0);  // nobody ever writes to it
  CHECK_FALSE(ResultFile(pipe.path()).exists());
  CHECK_FALSE(ResultFile(pipe.path() / "nowhere").exists());
  const Told names(R"({"labs": ["shark", "../x", "..", "", 3, "roark"]})");
  CHECK(names.file().labs() == std::vector<std::string>{"shark", "roark"});
}

TEST_CASE("a run goes on while the process that wrote so lives: its id, its host and when it began are the same") {
  using Runs = ResultFile::Runs;
  CHECK(Told(running(hal::own_process())).file().runs() == Runs::yes);
  CHECK(Told(running(own_with("began_ticks", 1))).file().runs() == Runs::no);  // another one had the id
  CHECK(Told(running(own_with("pid", 2'000'000'000))).file().runs() == Runs::no);
  CHECK(Told(running(own_with("host", "another machine"))).file().runs() == Runs::unknown);
  CHECK(Told(running({{"pid", 2'000'000'000}, {"began_ticks", 0}, {"host", hal::own_process().at("host")}}))
            .file()
            .runs() == Runs::no);
  CHECK(Told(running({{"pid", "1"}, {"host", hal::own_process().at("host")}})).file().runs() == Runs::no);
  CHECK(Told(running(json::object())).file().runs() == Runs::unknown);
  CHECK(Told(R"({"state": "running"})").file().runs() == Runs::no);  // no process is named
  json over = json::parse(running(hal::own_process()));
  hal::set_outcome(over, Outcome::finished);
  CHECK(Told(over.dump()).file().runs() == Runs::no);
  CHECK(Told(running(own_with("pid", 12))).file().goes_on_in_words().empty());
  const json elsewhere = {{"pid", 12}, {"host", "another machine"}};
  CHECK(Told(running(elsewhere)).file().goes_on_in_words() ==
        "the run of shark (process 12), which is still in progress");
}

TEST_CASE("only a run whose process is certainly gone is marked as killed, and it says so") {
  const Told gone(running(own_with("began_ticks", 1)));
  CHECK(gone.file().mark_killed());
  CHECK(gone.file().outcome() == Outcome::killed);
  CHECK(gone.file().ended().find("ended without a result") != std::string::npos);
  CHECK_FALSE(gone.file().mark_killed());
  for (const json& process : {hal::own_process(), own_with("host", "another machine")}) {
    const Told told(running(process));
    CHECK_FALSE(told.file().mark_killed());
    CHECK(told.file().outcome() == Outcome::running);
  }
}

TEST_CASE("a result that cannot take the file's place is told in place: at least how the run ended") {
  const tests::TemporaryDirectory root;
  const auto file = root.path() / "result.json";
  hal::save_running(file, {{"labs", {"shark"}}, {"process", hal::own_process()}});
  std::filesystem::create_directory(hal::part_of(file));  // in the way
  const auto size = std::filesystem::file_size(file);
  for (const std::string& ended : {std::string("the line was cut"), std::string(1000, 'x')}) {
    json result{{"counts", {{"n", 1}}}};
    hal::set_outcome(result, Outcome::failed, ended);
    hal::save_json(file, result);
    CHECK(std::filesystem::file_size(file) == size);
    const ResultFile now(root.path());
    CHECK(now.outcome() == Outcome::failed);
    CHECK(now.labs() == std::vector<std::string>{"shark"});
    CHECK(now.ended() == (ended.size() < 100 ? ended : "failed"));
  }
}
