// What a scenario may ask of its lab, and what it is answered when it asks too early or for what there is not.
#include <doctest/doctest.h>

#include <chrono>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "arkmesh/shown_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/bus/bus.hpp"
#include "hal/overlay/drawing_message.hpp"
#include "lab/exchange/shared_view.hpp"
#include "lab/lab.hpp"

using namespace arkmesh;

namespace {

struct Asked {
  lab::LabData data;
  lab::Lab lab{data};

  Asked() {
    data.name = data.owner = "a";
    data.labs = {"a", "b"};
    data.projections = {{"a", {}}, {"b", {.scale = 2}}};
    data.seed = 7;
    data.period_length = hal::LabTime(2'000'000);
  }
  void merge(std::uint32_t period) {
    lab::LabState own, other;
    own.fields["team"] = {1, 2};
    other.period = own.period = period;
    std::vector<lab::MergedState> merged;
    for (const auto& [name, state] : {std::pair("a", own), std::pair("b", other)}) {
      const auto kept = std::make_shared<const lab::LabState>(state);
      merged.push_back({name, kept, 0, period == 0 ? kept : nullptr});
    }
    lab::tell_merged(data, period, merged);
  }
};

template <class Ask>
std::string sentence(Ask ask) {
  try {
    ask();
  } catch (const std::logic_error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("before the first merge there are no states, and a sentence says so") {
  // A scenario that looks at states in begin() or at frame 0 is told when they are there.
  Asked asked;
  const std::string early =
      "the scenario asked for the state of 'b' before the first merge; states are available from on_period of period 0";
  CHECK(sentence([&] { asked.lab.state("b"); }) == early);
  CHECK(sentence([&] { asked.lab.field("b", "team"); }) == early);
  CHECK(sentence([&] { asked.lab.initial_field("b", "team"); }) == early);
  CHECK(asked.lab.projection("b").scale == 2);
}

TEST_CASE("a lab that there is not has neither state nor projection") {
  Asked asked;
  asked.merge(0);
  CHECK(asked.lab.state("b").period == 0);
  CHECK_THROWS_AS(asked.lab.state("c"), std::out_of_range);
  CHECK_THROWS_AS(asked.lab.initial_field("c", "team"), std::out_of_range);
  CHECK(sentence([&] { asked.lab.field("c", "team"); }) ==
        "the scenario asked for the state of 'c', which is not one of the labs a, b");
  CHECK(sentence([&] { asked.lab.projection("c"); }) ==
        "the scenario asked for the projection of 'c', which is not one of the labs a, b");
}

TEST_CASE("a field that a state does not hold is empty") {
  Asked asked;
  asked.merge(0);
  CHECK(asked.lab.field("a", "team") == std::vector<std::int64_t>{1, 2});
  CHECK(asked.lab.field("b", "team").empty());
  asked.merge(3);
  asked.data.states["a"] = std::make_shared<const lab::LabState>();
  CHECK(asked.lab.field("a", "team").empty());
  CHECK(asked.lab.initial_field("a", "team").size() == 2);
  CHECK(asked.lab.now() == hal::LabTime(6'000'000));
}

TEST_CASE("fields are declared in begin() only") {
  // Rules are the gate's from then on: a later declaration would do nothing and so must not pass.
  Asked asked;
  asked.lab.declare({.name = "team"});
  CHECK(sentence([&] { asked.lab.declare({.name = "team"}); }) ==
        "the scenario declared field 'team' twice; give each its own name");
  asked.data.declaring = false;
  CHECK(sentence([&] { asked.lab.declare({.name = "late"}); }) ==
        "the scenario declared field 'late' after begin(); declare all fields in begin()");
  CHECK(asked.data.rules.size() == 1);
}

TEST_CASE("a random stream is named lab/purpose and stays where it is") {
  Asked asked;
  hal::RandomStream expected(7, "a/sites");
  hal::RandomStream& stream = asked.lab.random("sites");
  CHECK(stream.next() == expected.next());
  for (int i = 0; i < 100; ++i) asked.lab.random(std::to_string(i));
  CHECK(&asked.lab.random("sites") == &stream);
  CHECK(stream.count() == 1);
}

TEST_CASE("a common random stream is the same in all labs, and another than each lab's own") {
  Asked a, b;
  b.data.name = "b";
  const auto common = a.lab.common_random("sites").next();
  CHECK(b.lab.common_random("sites").next() == common);
  CHECK(a.lab.common_random("sites").next() != common);  // it goes on
  CHECK(a.lab.random("sites").next() != common);
  CHECK(a.lab.random("sites").next() != b.lab.random("sites").next());
}

TEST_CASE("what a scenario draws is shown until the next boundary, and what cannot be drawn is counted") {
  // Five kinds of shapes; a boundary takes them away, and viewers are told so once.
  Asked asked;
  hal::Bus bus("memq://");
  std::vector<std::int64_t> shapes;
  const auto subscription =
      bus.subscribe(hal::channel::overlay, [&](std::string_view, std::span<const std::byte> bytes) {
        hal::Drawing drawing;
        hal::Counters refused;
        REQUIRE(hal::read_overlay(bytes, drawing, refused));
        shapes.push_back(static_cast<std::int64_t>(drawing.size()));
      });
  const auto boundary = [&](std::uint32_t period, bool draws) {
    asked.merge(period);
    if (draws) {
      asked.lab.draw(hal::Circle{.at = {0.1, 0.2}, .radius_m = 0.1});
      asked.lab.draw(hal::Polygon{.corners = {{0, 0}, {1, 0}, {0, 1}}});
      asked.lab.draw(hal::Line{.points = {{0, 0}, {1, 0}}});
      asked.lab.draw(hal::Text{.at = {0, 0}, .text = "here"});
      asked.lab.draw(hal::Raster{.cell_m = 0.1, .columns = 1, .cells = {7}});
      asked.lab.draw(hal::Circle{.radius_m = -1});
      asked.lab.draw(hal::Text{.text = "two\nlines"});
    }
    lab::publish_shared(bus, asked.data, {});
    bus.drain();
  };
  boundary(0, false);
  CHECK(shapes.empty());
  for (std::uint32_t period = 1; period < 5; ++period) boundary(period, period < 3);
  CHECK(shapes == std::vector<std::int64_t>{5, 5, 0});
  CHECK(asked.lab.counts()["overlay.refused.number"] == 2);
  CHECK(asked.lab.counts()["overlay.refused.label"] == 2);
}

TEST_CASE("rows of a table have its columns, and one value for each") {
  // Another header, more or fewer values, and tables of the lab's own are refused by the table's name.
  Asked asked;
  asked.lab.row("t", "x,y", "1,\"2,3\"");
  asked.lab.row("u", "y,x", "1,2");
  const auto refused = [&](const char* table, const char* header, const char* values) {
    return sentence([&] { asked.lab.row(table, header, values); })
        .starts_with(std::string("a row of table '") + table + "' must have the columns of its first row, ");
  };
  CHECK(refused("t", "y,x", "1,2"));
  CHECK(refused("t", "x,y", "1"));
  CHECK(refused("t", "x,y", "1,2,3"));
  CHECK(refused("u", "y,x,z", "1,2,3"));
  CHECK(refused("hash", "x", "1"));
  CHECK(refused("audit", "x", "1"));
  CHECK(refused("curves", "x", "1"));
  CHECK(asked.data.rows.size() == 2);
}

TEST_CASE("a scenario says in words what people see, at the start and every 60 s") {
  // The last words of each are told, in the order of the first ones; what there is none of is refused.
  Asked asked;
  hal::Bus bus("memq://");
  std::vector<std::string> told;
  const auto subscription = bus.subscribe(hal::channel::shown, [&](std::string_view, std::span<const std::byte> bytes) {
    shown_t message;
    REQUIRE(hal::read_message(bytes, message).empty());
    for (const shown_words_t& each : message.words)
      told.push_back(each.of + "=" + each.words + "|" + each.unit + (each.curve ? "|curve" : ""));
  });
  const auto boundary = [&](std::uint32_t period) {
    asked.merge(period);
    lab::publish_shared(bus, asked.data, {});
    bus.drain();
  };
  boundary(0);
  CHECK(told.empty());
  asked.lab.show({.of = "series.trips", .words = "before"});
  asked.lab.show({.of = "colour.site_hard", .words = "hard, here + there"});
  asked.lab.show({.of = "series.trips", .words = "trips home", .unit = "trips", .curve = true});
  for (std::uint32_t period = 0; period <= 30; ++period) boundary(period);  // of 2 s
  const std::vector<std::string> once{"series.trips=trips home|trips|curve", "colour.site_hard=hard, here + there|"};
  CHECK(told == std::vector<std::string>{once[0], once[1], once[0], once[1]});
  told.clear();
  asked.data.period_length = std::chrono::seconds(7);
  for (std::uint32_t period = 1; period <= 18; ++period) boundary(period);  // at 63 and 126 s
  CHECK(told == std::vector<std::string>{once[0], once[1], once[0], once[1]});
  for (const std::string& of :
       {"trips", "series.", "series.a,b", "series.a\nb", "colour.mauve", "led.9", "led.red", ".", ""})
    CHECK(sentence([&] { asked.lab.show({.of = of}); }).find("cannot be shown; up to 256 of series.NAME") !=
          std::string::npos);
  CHECK(sentence([&] { asked.lab.show({.of = "led.1", .words = std::string(121, 'x')}); }) != "no error");
  asked.data.declaring = false;
  CHECK(sentence([&] { asked.lab.show({.of = "led.1"}); }) ==
        "the scenario shows 'led.1' after begin(); declare in begin() what is shown");
}

TEST_CASE("counts that are shown as curves have a table with a row a second, or a period") {
  // Also one that nothing was counted of yet; no column of a table, and no table where no count is shown.
  Asked asked;
  const auto rows_of = [&](hal::LabTime period) {
    asked.data.rows.clear();
    asked.data.curves.clear();
    asked.data.period_length = period;
    for (std::uint32_t k = 0; k <= 4; ++k) {
      asked.merge(k);
      asked.lab.counts().set("trips", 10 * k);
      lab::add_curves(asked.data);
    }
    std::string out;
    for (const lab::Row& row : asked.data.rows) out += row.table + ": " + row.header + ": " + row.values + "\n";
    return out;
  };
  CHECK(rows_of(std::chrono::seconds(2)).empty());
  for (const char* of : {"series.trips", "series.late", "series.swarms.north"})
    asked.lab.show({.of = of, .curve = true});
  asked.lab.show({.of = "series.lost"});
  CHECK(rows_of(std::chrono::seconds(2))
            .starts_with("curves: time_s,trips,late: 0,0,0\ncurves: time_s,trips,late: 2,10,0\n"));
  CHECK(rows_of(std::chrono::milliseconds(500)) ==
        "curves: time_s,trips,late: 0,0,0\ncurves: time_s,trips,late: 1,20,0\ncurves: time_s,trips,late: 2,40,0\n");
}

TEST_CASE("wheels are set where there are some, said when they change, and refused by name elsewhere") {
  Asked asked;
  asked.data.arena.make = "walker";
  CHECK(sentence([&] { asked.lab.drive(3, {.left_mm_s = 10, .right_mm_s = 20}); }) ==
        "the scenario drives robot 3, but a lab cannot set the wheels of a walker; only its own program moves it");
  CHECK(asked.data.to_robots.empty());
  asked.data.arena.drive = {.way = hal::RobotDrive::Way::differential, .speed_m_s = 0.1, .wheels_apart_m = 0.05};
  for (const int left_mm_s : {10, 10, -50}) asked.lab.drive(3, {.left_mm_s = left_mm_s, .right_mm_s = 20});
  REQUIRE(asked.data.to_robots.size() == 2);
  CHECK(hal::set_point_in(asked.data.arena, asked.data.to_robots[1]) ==
        hal::SetPoint{.left_mm_s = -50, .right_mm_s = 20});
}
