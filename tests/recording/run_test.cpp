// Run folders of all kinds: what is in them is found, and what is not is said in a sentence.
#include "recording/run.hpp"

#include <doctest/doctest.h>

#include <fstream>
#include <string>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/pose_frame_t.hpp"
#include "arkmesh/shared_view_t.hpp"
#include "hal/record/recorder.hpp"
#include "recording/csv_table.hpp"
#include "recording/view/moments.hpp"
#include "recording/view/run_story.hpp"
#include "tests/recording/recorded_lab.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
using namespace arkmesh::recording;
using arkmesh::tests::TemporaryDirectory;
namespace fs = std::filesystem;

TEST_CASE("a folder of several labs, and that of one, are runs") {
  const TemporaryDirectory directory;
  tests::record_lab(directory.path() / "shark", "shark", 20);
  tests::record_lab(directory.path() / "roark", "roark", 30);
  const Run run(directory.path());
  REQUIRE(run.labs().size() == 2);
  CHECK(run.labs()[0].name == "roark");
  CHECK(run.length_us() == 2'900'000);
  CHECK_FALSE(run.is_growing());
  CHECK(run.notes().empty());
  const Run one(directory.path() / "shark");
  REQUIRE(one.labs().size() == 1);
  CHECK(one.labs()[0].name == "shark");
}

TEST_CASE("what is no run is refused with what to do") {
  const TemporaryDirectory directory;
  CHECK_THROWS_WITH(Run(directory.path() / "none"), doctest::Contains("is not a folder"));
  CHECK_THROWS_WITH(Run(directory.path()), doctest::Contains("is no run folder"));
  fs::create_directories(directory.path() / "batch/runs/00000/shark");
  std::ofstream(directory.path() / "batch/runs/00000/shark/config.toml") << "";
  CHECK_THROWS_WITH(Run(directory.path() / "batch"),
                    doctest::Contains("runs/00000/*/config.toml --set recorder.log=true"));
  tests::record_lab(directory.path() / "runs" / "00010" / "shark", "shark", 5);
  tests::record_lab(directory.path() / "runs" / "00009" / "shark", "shark", 5);
  CHECK_THROWS_WITH(Run(directory.path()), doctest::Contains("2 runs of a batch"));
  const auto runs = runs_of_batch(directory.path());
  REQUIRE(runs.size() == 2);
  CHECK(runs[0].filename() == "00009");
}

TEST_CASE("a log of another version is used as far as it is known, and said") {
  const TemporaryDirectory directory;
  tests::record_lab(directory.path(), "shark", 5);
  std::string log = tests::read_file(directory.path() / "log.lcm");
  fs::remove(directory.path() / "log.lcm");
  const std::size_t place = log.find("poses") + 5;
  for (std::size_t at = place; at != std::string::npos + 5 && at < log.size(); at = log.find("poses", at) + 5) {
    log[at] = static_cast<char>(log[at] ^ 1);
    if (log.find("poses", at) == std::string::npos) break;
  }
  directory.write("log.lcm", log);
  const Run run(directory.path());
  const auto notes = run.notes();
  REQUIRE(notes.size() == 1);
  CHECK(notes[0].find("is of another version of arkmesh") != std::string::npos);
  CHECK(notes[0].find("poses") != std::string::npos);
}

TEST_CASE("a log that is cut is used, and said") {
  const TemporaryDirectory directory;
  tests::record_lab(directory.path(), "shark", 20);
  fs::resize_file(directory.path() / "log.lcm", fs::file_size(directory.path() / "log.lcm") - 3);
  const Run run(directory.path());
  REQUIRE(run.notes().size() == 1);
  CHECK(run.notes()[0].find("is cut or damaged") != std::string::npos);
}

TEST_CASE("messages whose time goes back stand at the time before, and are said") {
  const TemporaryDirectory directory;
  {
    hal::Recorder recorder(directory.path(), 1'700'000'000'000'000, {});
    for (const int second : {0, 1, 3, 2, 1, 4}) recorder.record(hal::LabTime{second * 1'000'000}, "clock", {});
  }
  const Run run(directory.path());
  CHECK(run.labs()[0].log->entries()[3].t_us == 3'000'000);
  REQUIRE(run.notes().size() == 1);
  CHECK(run.notes()[0].find("has 2 messages with a time before") != std::string::npos);
}

TEST_CASE("tables are read, and a row that is cut is left out") {
  const TemporaryDirectory directory;
  const CsvTable table = read_csv_table(directory.write("t.csv", "time_s,name,n\n1.5,\"a,\"\"b\",3\n2.5,c,4\n3.5,d"));
  REQUIRE(table.columns.size() == 3);
  CHECK(table.rows == 2);
  CHECK(table.dropped == 1);
  CHECK(table.columns[0].kind == CsvTable::real);
  CHECK(table.columns[1].texts[0] == "a,\"b");
  CHECK(table.columns[2].kind == CsvTable::integer);
  CHECK(table.number(0, 1) == 2.5);
  CHECK(read_csv_table(directory.write("none.csv", "")).columns.empty());
}

TEST_CASE("a table that lists what happened gives events and a count, one that samples gives its columns") {
  const TemporaryDirectory directory;
  tests::record_lab(directory.path(), "shark", 20);
  directory.write("completed.csv", "period,time_s,site\n1,0.2,7\n3,0.6,2\n4,0.8,1\n");
  directory.write("swarms.csv", "time_s,north\n0,1\n1,3\n2,5\n");
  const Run run(directory.path());
  const auto events = events_of(run.labs()[0]);
  REQUIRE(events.size() == 3);
  CHECK(events[1].t_us == 600'000);
  CHECK(events[1].kind == "completed");
  CHECK(events[1].text == "completed: period 3, site 2");
  const auto series = series_of(run.labs()[0]);
  REQUIRE(series.size() == 2);
  CHECK(series[0].name == "completed");
  CHECK(series[0].y == std::vector<double>{0, 1, 2, 3});
  CHECK(series[1].name == "swarms.north");
  CHECK(series[1].y == std::vector<double>{1, 3, 5});
}

TEST_CASE("counts that the scenario shows have their table's curve, and others that of the lab's statuses") {
  const TemporaryDirectory directory;
  tests::record_lab(directory.path(), "shark", 20);
  {
    hal::Recorder recorder(directory.path(), 1'700'000'000'000'000, {});
    lab_status_t status{};
    for (const int second : {0, 1, 1, 3}) {
      status.stamp_us = second * 1'000'000;
      status.counters.resize(3);
      status.counters[0].name = "counts.lost", status.counters[0].value = second * second;
      status.counters[1].name = "counts.trips", status.counters[1].value = 99;
      status.counters[2].name = "link.up";
      status.n_counters = 3;
      std::vector<std::byte> bytes(static_cast<std::size_t>(status.getEncodedSize()));
      status.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
      recorder.record(hal::LabTime{second * 1'000'000}, "status", bytes);
    }
  }
  directory.write("curves.csv", "time_s,trips\n0,0\n1,4\n");
  const Run run(directory.path());
  CHECK(events_of(run.labs()[0]).size() <= 1);  // the state; no row of curves
  const auto series = series_of(run.labs()[0]);
  REQUIRE(series.size() == 2);
  CHECK(series[0].name == "trips");
  CHECK(series[0].y == std::vector<double>{0, 4});
  CHECK(series[1].name == "lost");
  CHECK(series[1].t_s == std::vector<double>{0, 1, 3});
  CHECK(series[1].y == std::vector<double>{0, 1, 9});
}

TEST_CASE("two runs differ from the first period with another hash") {
  const TemporaryDirectory a, b;
  tests::record_lab(a.path(), "shark", 20);
  tests::record_lab(b.path(), "shark", 20);
  a.write("hash.csv", "period,hash\n0,aa\n1,bb\n2,cc\n");
  b.write("hash.csv", "period,hash\n0,aa\n1,bb\n2,dd\n3,ee\n");
  const Comparison comparison = compare(Run(a.path()), Run(b.path()));
  REQUIRE(comparison.first.has_value());
  CHECK(comparison.first->period == 2);
  CHECK(comparison.first->lab == "shark");
  b.write("hash.csv", "period,hash\n0,aa\n1,bb\n2,cc\n3,ee\n");
  CHECK(compare(Run(a.path()), Run(b.path())).in_words() == "the runs are equal in all 3 periods that both have");
}

TEST_CASE("a row of moments gives each message once, and goes on where the row before ended") {
  const TemporaryDirectory directory;
  tests::record_lab(directory.path(), "shark", 100);
  const Run run(directory.path());
  const Log& log = *run.labs()[0].log;
  std::vector<std::int64_t> times;
  const auto take = [&](std::int64_t t, const std::string&, std::span<const std::byte>) {
    times.push_back(t);
    return true;
  };
  CHECK(give_moment(log, 1'234'567, {"poses"}, take));
  CHECK(times == std::vector<std::int64_t>{1'200'000});
  times.clear();
  CHECK(give_row(log, {1'250'000, 50'000, 4}, {"poses"}, take));
  CHECK(give_row(log, {1'450'000, 50'000, 4}, {"poses"}, take));
  CHECK(times == std::vector<std::int64_t>{1'300'000, 1'400'000, 1'500'000, 1'600'000});
  times.clear();
  CHECK(give_row(log, {200'000, 1'000'000, 50}, {"poses"}, take));  // ten times faster
  CHECK(times.size() == 11);
  CHECK(times.back() == 9'900'000);
}
