// The owner's decisions, boundary by boundary.
#include "scenarios/dhtf/task_coordinator.hpp"

#include <doctest/doctest.h>

using namespace arkmesh;
using namespace arkmesh::scenarios::dhtf;

namespace {

using Teams = std::vector<std::vector<std::int64_t>>;
const std::vector<std::int64_t> both{1, 1};
constexpr hal::LabTime second{1'000'000};

// Lab 0 needs 1 and 2 robots at the two sites, lab 1 needs 2 and 4.
TaskCoordinator two_labs() {
  return TaskCoordinator({{1, 2}, {2, 4}}, 40 * second);
}

}  // namespace

TEST_CASE("dhtf coordinator: a task needs the team of every lab") {
  // Executed exactly when every lab has at least what the task needs there.
  struct Row {
    std::int64_t first, second, executed;
  };
  for (const Row& row : {Row{0, 0, 0}, Row{1, 0, 0}, Row{1, 1, 0}, Row{0, 2, 0}, Row{0, 9, 0}, Row{9, 1, 0},
                         Row{1, 2, 1}, Row{3, 2, 1}, Row{1, 7, 1}}) {
    TaskCoordinator coordinator = two_labs();
    CHECK(coordinator.update(2 * second, Teams{{row.first, 0}, {row.second, 0}}, both) == (row.executed == 1));
    CHECK(coordinator.executed() == std::vector<std::int64_t>{row.executed, 0});
    CHECK(coordinator.active() == std::vector<std::int64_t>{1 - row.executed, 1});
  }
  // The second site has needs of its own, and remembers who was there.
  TaskCoordinator coordinator = two_labs();
  CHECK(!coordinator.update(2 * second, Teams{{0, 2}, {0, 3}}, both));
  CHECK(coordinator.update(4 * second, Teams{{0, 2}, {0, 5}}, both));
  CHECK(coordinator.executed_by() == std::vector<std::int64_t>{0, 2, 0, 5});
}

TEST_CASE("dhtf coordinator: three labs") {
  // With three labs two teams are not enough.
  TaskCoordinator coordinator({{1}, {1}, {2}}, 40 * second);
  CHECK(!coordinator.update(2 * second, Teams{{1}, {1}, {1}}, {1}));
  CHECK(!coordinator.update(4 * second, Teams{{1}, {0}, {2}}, {1}));
  CHECK(coordinator.update(6 * second, Teams{{1}, {1}, {2}}, {1}));
}

TEST_CASE("dhtf coordinator: a lab not heard of executes nothing") {
  // An unknown team, or unknown activity, stops the site, whatever the others have.
  TaskCoordinator coordinator = two_labs();
  CHECK(!coordinator.update(2 * second, Teams{{9, 9}, {}}, both));
  CHECK(!coordinator.update(2 * second, Teams{{9, 9}, {9, 9}}, {}));
  CHECK(coordinator.executed() == std::vector<std::int64_t>{0, 0});
}

TEST_CASE("dhtf coordinator: no second execution while the decision is on its way, and an exact respawn") {
  // A team that stays is not counted again, before the decision is in force, during the respawn, or before the labs
  // know of the respawn; the site is decided active exactly 40 s after it was decided inactive.
  TaskCoordinator coordinator({{1}}, 40 * second);
  const Teams there{{1}};
  CHECK(coordinator.update(2 * second, there, {1}));
  CHECK(!coordinator.update(4 * second, there, {1}));
  for (int t = 6; t < 42; t += 2) CHECK(!coordinator.update(t * second, there, {0}));
  CHECK(coordinator.active() == std::vector<std::int64_t>{0});
  CHECK(coordinator.update(42 * second, there, {0}));
  CHECK(coordinator.active() == std::vector<std::int64_t>{1});
  CHECK(!coordinator.update(44 * second, there, {0}));
  CHECK(coordinator.executed() == std::vector<std::int64_t>{1});
  CHECK(coordinator.update(46 * second, there, {1}));
  CHECK(coordinator.executed() == std::vector<std::int64_t>{2});
}
