// What the page gets of the counts of a run that has gone on for long.
#include "app/live/count_history.hpp"

#include <doctest/doctest.h>

using namespace arkmesh;
using nlohmann::json;

TEST_CASE("curves begin with the run; what is counted later had nothing before, and a lab that begins anew too") {
  app::CountHistory history;
  hal::Counters counts;
  CHECK(history.series("shark") == json::array());
  history.note(0, counts);
  counts.add("completed");
  history.note(2'000'000, counts);
  history.note(2'000'000, counts);
  counts.add("completed", 2);
  counts.add("begun", 5);
  history.note(4'000'000, counts);
  history.note(6'000'000, {});  // a status that lists none
  CHECK(history.series("shark") == json{{{"name", "shark begun"}, {"t_s", {0, 2, 4, 6}}, {"y", {0, 0, 5, 5}}},
                                        {{"name", "shark completed"}, {"t_s", {0, 2, 4, 6}}, {"y", {0, 1, 3, 3}}}});
  history.note(0, {});
  history.note(1'000'000, counts);
  CHECK(history.series("roark")[1] == json{{"name", "roark completed"}, {"t_s", {0, 1}}, {"y", {0, 3}}});
}

TEST_CASE("a day is kept in a bounded number of moments, evenly, from its beginning") {
  app::CountHistory history;
  hal::Counters counts;
  for (std::int64_t period = 0; period < 43'200; ++period) {
    counts.set("completed", static_cast<std::uint64_t>(period));
    history.note(period * 2'000'000, counts);
  }
  const json series = history.series("shark")[0];
  const auto t_s = series["t_s"].get<std::vector<double>>();
  const auto y = series["y"].get<std::vector<std::uint64_t>>();
  REQUIRE(t_s.size() == y.size());
  CHECK(t_s.size() < app::CountHistory::max_moments);
  CHECK(t_s.size() >= app::CountHistory::max_moments / 2);
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    CHECK(t_s[i] == 128.0 * static_cast<double>(i));
    CHECK(y[i] == 64 * i);
  }
  CHECK(t_s.back() > 86'400 - 128 - 2);
}

TEST_CASE("names without end take no room") {
  app::CountHistory history;
  for (int i = 0; i < 1000; ++i) {
    hal::Counters counts;
    counts.add("name" + std::to_string(i));
    history.note(i, counts);
  }
  CHECK(history.series("shark").size() == app::CountHistory::max_names);
}
