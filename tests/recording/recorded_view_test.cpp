// The page of recorded runs before a viewer: what it asks for comes from the logs, and what makes no sense is refused.
#include "recording/view/recorded_view.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <bit>
#include <boost/asio/io_context.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hal/layout/message.hpp"
#include "tests/recording/recorded_lab.hpp"
#include "tests/support/processes/temporary_directory.hpp"
#include "tests/support/view/browser.hpp"

using namespace arkmesh;
using arkmesh::tests::Browser;
using arkmesh::tests::TemporaryDirectory;
using nlohmann::json;

namespace {

struct ViewBench {
  explicit ViewBench(const std::vector<std::filesystem::path>& folders)
      : view(loop, folders, {.port = 0}), browser(loop, view.port()) {
    REQUIRE(browser.join() == 101);
    REQUIRE(browser.hears("hello"));
  }
  // What is done or refused for a request.
  json ask(json what) {
    what["request"] = ++number;
    browser.say(what);
    json out;
    tests::comes_to(tests::serving(loop), [&] {
      for (const char* member : {"done", "refused"})
        if (const json said = browser.said(member); said.is_object() && said.value("request", 0) == number)
          out = {{member, said}};
      return !out.is_null();
    });
    return out;
  }
  // The recorded messages that came for the last request, as "LAB CHANNEL T_US".
  std::vector<std::string> given() {
    std::vector<std::string> out;
    for (const auto& message : browser.messages())
      if (message.kind() == 1 && message.request() == static_cast<std::uint32_t>(number))
        out.push_back(std::to_string(message.lab()) + " " + message.channel() + " " + std::to_string(message.t_us()));
    return out;
  }

  boost::asio::io_context loop;
  recording::RecordedView view;
  Browser browser;
  int number = 0;
};

}  // namespace

TEST_CASE("a recorded run tells what it is, and answers seek and frames from its logs") {
  const TemporaryDirectory directory;
  tests::record_lab(directory.path() / "shark", "shark", 50);
  tests::record_lab(directory.path() / "roark", "roark", 30);
  ViewBench bench({directory.path()});
  const json hello = bench.browser.said("hello");
  CHECK(hello.at("mode") == "recorded");
  CHECK(hello.at("labs") == json({"roark", "shark"}));
  CHECK(hello.at("length_us") == 4'900'000);
  CHECK(hello.at("growing") == false);
  CHECK(hello.at("control") == false);

  CHECK(bench.ask({{"seek", {{"t_us", 3'333'333}}}}).contains("done"));
  CHECK(bench.given() == std::vector<std::string>{"0 poses 2900000", "1 poses 3300000"});
  std::string data;
  for (const auto& message : bench.browser.messages())
    if (message.kind() == 1 && message.lab() == 1) data = message.data();
  const pose_frame_t frame = tests::recorded_frame(33);
  std::string expected(static_cast<std::size_t>(frame.getEncodedSize()), '\0');
  frame.encode(expected.data(), 0, static_cast<int>(expected.size()));
  CHECK(data == expected);

  CHECK(bench.ask({{"frames", {{"from_us", 4'000'000}, {"step_us", 100'000}, {"count", 3}, {"channels", {"poses"}}}}})
            .contains("done"));
  CHECK(bench.given() == std::vector<std::string>{"1 poses 4000000", "1 poses 4100000", "1 poses 4200000"});
  CHECK(bench.ask({{"frames", {{"from_us", 4'000'000}, {"step_us", 100'000}, {"count", 3}, {"channels", {"shared"}}}}})
            .contains("done"));
  CHECK(bench.given().empty());
}

TEST_CASE("what makes no sense is refused, and the page goes on") {
  const TemporaryDirectory directory;
  tests::record_lab(directory.path(), "shark", 5);
  ViewBench bench({directory.path()});
  const json nonsense[] = {{{"seek", nullptr}},
                           {{"seek", {{"t_us", "soon"}}}},
                           {{"seek", {{"t_us", 1e300}}}},
                           {{"frames", {{"from_us", 0}, {"step_us", 0}, {"count", 3}}}},
                           {{"frames", {{"from_us", 0}, {"step_us", 1}, {"count", 1'000'000'000}}}},
                           {{"frames", json::array({1, 2})}},
                           {{"open", {{"run", 1}}}},
                           {{"open", nullptr}},
                           {{"dance", true}}};
  for (const json& what : nonsense) CHECK(bench.ask(what).contains("refused"));
  CHECK(bench.ask({{"seek", {{"t_us", 0}}}}).contains("done"));
}

TEST_CASE("two runs stand side by side, with the first period in which they differ") {
  const TemporaryDirectory a, b;
  tests::record_lab(a.path(), "shark", 10);
  tests::record_lab(b.path(), "shark", 10);
  a.write("hash.csv", "period,hash\n0,aa\n1,bb\n");
  b.write("hash.csv", "period,hash\n0,aa\n1,cc\n");
  ViewBench bench({a.path(), b.path()});
  const json hello = bench.browser.said("hello");
  CHECK(hello.at("labs") == json({a.path().filename().string() + "/shark", b.path().filename().string() + "/shark"}));
  CHECK(hello.at("first_difference").at("period") == 1);
  const json events = bench.ask({{"events", json::object()}});
  CHECK(events.at("done").at("events").back().at("kind") == "difference");
}

TEST_CASE("of a batch the first run is shown, and others are opened") {
  const TemporaryDirectory directory;
  tests::record_lab(directory.path() / "runs/00000" / "shark", "shark", 10);
  tests::record_lab(directory.path() / "runs/00001" / "shark", "shark", 20);
  ViewBench bench({directory.path()});
  CHECK(bench.browser.said("hello").at("runs") == json({"00000", "00001"}));
  CHECK(bench.browser.said("hello").at("number") == 0);
  CHECK(bench.browser.said("hello").at("length_us") == 900'000);
  const json done = bench.ask({{"open", {{"run", 1}}}});
  CHECK(done.at("done").at("about").at("number") == 1);
  CHECK(done.at("done").at("about").at("length_us") == 1'900'000);
  for (const json& wrong : {json(2), json(-1), json(1e300), json("first"), json()}) {
    CHECK(bench.ask({{"open", {{"run", wrong}}}}).contains("refused"));
    CHECK(bench.ask({{"run", wrong}, {"seek", {{"t_us", 0}}}}).contains("refused"));
  }
}

TEST_CASE("the table of a batch is given with the runs that have a recording") {
  // A run without one has none; a run of one folder, and a batch without its table, are refused.
  const TemporaryDirectory directory;
  tests::record_lab(directory.path() / "runs/00000" / "shark", "shark", 10);
  tests::record_lab(directory.path() / "runs/00012" / "shark", "shark", 10);
  ViewBench bench({directory.path()});
  CHECK(bench.ask({{"batch", json::object()}}).at("refused").at("why").get<std::string>().find("--gather") !=
        std::string::npos);
  directory.write("runs.csv",
                  "run,setting,scenario.x.reach,seed,state,trips\n0,0,0.1,1,finished,3\n5,0,0.1,2,failed,\n12,1,\"a,"
                  "b\",1,finished,4\n");
  const json table = bench.ask({{"batch", json::object()}}).at("done").at("batch");
  CHECK(table.at("factors") == 1);
  CHECK(table.at("columns") == json({"run", "setting", "scenario.x.reach", "seed", "state", "trips"}));
  REQUIRE(table.at("rows").size() == 3);
  CHECK(table.at("rows")[0] == json({{"run", 0}, {"cells", {"0", "0", "0.1", "1", "finished", "3"}}}));
  CHECK(table.at("rows")[1].at("run").is_null());
  CHECK(table.at("rows")[2] == json({{"run", 1}, {"cells", {"12", "1", "a,b", "1", "finished", "4"}}}));
  ViewBench one({directory.path() / "runs/00000"});
  CHECK(one.ask({{"batch", json::object()}}).contains("refused"));
}

TEST_CASE("each viewer of a batch sees the run that it named, whatever others open") {
  const TemporaryDirectory directory;
  constexpr int runs = 40;  // more than are open at a time
  for (int i = 0; i < runs; ++i) {
    const std::string name = fmt::format("runs/{:05}", i);
    tests::record_lab(directory.path() / name / "shark", "shark", 10 + i);
  }
  ViewBench bench({directory.path()});
  const auto length = [&](const json& answer) { return answer.at("done").at("length_us").get<int>() / 100'000 + 1; };
  for (int i = 1; i < runs; ++i) CHECK(bench.ask({{"open", {{"run", i}}}}).contains("done"));
  // One who names none sees the first run, also when others were opened since.
  CHECK(length(bench.ask({{"seek", {{"t_us", 0}}}})) == 10);
  // Those that were closed meanwhile are opened again.
  for (int i = 0; i < runs; ++i) {
    CHECK(length(bench.ask({{"run", i}, {"seek", {{"t_us", 60'000'000}}}})) == 10 + i);
    CHECK(bench.given() == std::vector<std::string>{fmt::format("0 poses {}", (9 + i) * 100'000)});
  }
  // A log holds a file open while it is.
  const auto files = std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
  CHECK(files < 32 + 40);
  CHECK(bench.browser.said("hello").at("number") == 0);
}

TEST_CASE("a run that goes on gives what is written meanwhile") {
  const TemporaryDirectory directory;
  hal::Recorder recorder(directory.path(), 1'700'000'000'000'000, {});
  const auto record = [&](int from, int to) {
    for (int n = from; n < to; ++n) {
      const pose_frame_t frame = tests::recorded_frame(n);
      std::vector<std::byte> bytes(static_cast<std::size_t>(frame.getEncodedSize()));
      frame.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
      recorder.record(hal::LabTime{n * 100'000}, "poses", bytes);
    }
    recorder.flush();
  };
  record(0, 10);
  directory.write("result.json",
                  R"({"lab": "shark", "state": "running", "process": {"pid": 1, "host": "another machine"}})");
  ViewBench bench({directory.path()});
  CHECK(bench.browser.said("hello").at("growing") == true);
  record(10, 20);
  CHECK(tests::comes_to(tests::serving(bench.loop), [&] {
    return bench.ask({{"seek", {{"t_us", 5'000'000}}}}).at("done").at("length_us") == 1'900'000;
  }));
  CHECK(bench.given() == std::vector<std::string>{"0 poses 1900000"});
}
