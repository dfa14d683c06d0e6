// ARK's identification, against a model of robots, air and camera.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "tests/tracker/identity/spelling_robots.hpp"
#include "tracker/identity/ark_identifier.hpp"

using namespace arkmesh;
using namespace arkmesh::tracker;

namespace {

// Names by track, once it has finished; at most so long.
std::map<TrackNumber, hal::RobotId> run(ArkIdentifier& identifier, SpellingRobots& robots, double max_s) {
  std::map<TrackNumber, hal::RobotId> out;
  while (!identifier.finished() && robots.seconds() < max_s) {
    identifier.on_frame(robots.now, robots.next_picture(identifier.question()));
    for (const Naming& naming : identifier.take_namings()) out[naming.track] = naming.robot;
  }
  return out;
}

}  // namespace

TEST_CASE("identity: ARK's protocol names everybody, ids above 255 too") {
  // Under bad conditions, with both of ARK's messages; the same names as the robots', each in less than a second of its
  // own.
  const std::vector<hal::RobotId> ids = {0, 3, 17, 255, 256, 300, 511, 1022};
  for (const bool runtime : {false, true}) {
    SpellingRobots robots(ids, {.loss = 0.1, .unseen = 0.05, .wrong = 0.01});
    ArkIdentifier identifier({.candidates = ids, .runtime = runtime});
    const auto names = run(identifier, robots, 60);
    CHECK(identifier.finished());
    CHECK(robots.seconds() < 20);
    CHECK(names.size() == ids.size());
    for (const auto& [track, robot] : names) CHECK(robots.by_track(track).id == robot);
    CHECK_FALSE(identifier.question());
  }
}

TEST_CASE("identity: ARK's protocol without a list of ids") {
  // All ids are called from 0 on, until everybody in the picture is named.
  SpellingRobots robots({4, 0, 9}, {.loss = 0.1});
  ArkIdentifier identifier({.largest = 50});
  const auto names = run(identifier, robots, 120);
  CHECK(identifier.finished());
  CHECK(robots.seconds() < 15);
  for (const auto& [track, robot] : names) CHECK(robots.by_track(track).id == robot);
  CHECK(names.size() == 3);
}

TEST_CASE("identity: ARK's protocol with doubles, dead and always blue robots") {
  // A double id names nobody; a robot that is blue whatever is called is seen through, and those called meanwhile are
  // called again.
  SpellingRobots robots({1, 2, 2, 3, 4, 5, 6}, {});
  robots.by_id(4).deaf = true;  // its program shows blue
  robots.by_id(3).dark = true;
  ArkIdentifier identifier({.candidates = {1, 2, 3, 4, 5, 6}});
  const auto names = run(identifier, robots, 120);
  CHECK(identifier.finished());
  for (const auto& [track, robot] : names) CHECK(robots.by_track(track).id == robot);
  CHECK(names.size() == 3);  // 1, 5, 6
  CHECK(std::ranges::find(identifier.duplicates(), 2u) != identifier.duplicates().end());
}

TEST_CASE("identity: ARK's protocol forgets who was hidden") {
  // A robot covered for a second after it answered is called again before it is named.
  SpellingRobots robots({0, 1, 2, 3}, {});
  ArkIdentifier identifier({.candidates = {0, 1, 2, 3}});
  std::map<TrackNumber, hal::RobotId> names;
  while (!identifier.finished() && robots.seconds() < 60) {
    if (robots.seconds() > 1.5 && robots.seconds() < 1.6)
      robots.by_id(0).hidden = true, robots.by_id(0).hidden_since = robots.now;
    if (robots.seconds() > 2.6 && robots.by_id(0).hidden) {
      robots.by_id(0).hidden = false;
      std::swap(robots.by_id(0).track, robots.by_id(3).track);
    }
    identifier.on_frame(robots.now, robots.next_picture(identifier.question()));
    for (const Naming& naming : identifier.take_namings()) names[naming.track] = naming.robot;
  }
  CHECK(identifier.finished());
  CHECK(identifier.counters()["identity.doubted.unseen"] == 1);
  CHECK(names.size() == 4);
  for (const auto& [track, robot] : names) CHECK(robots.by_track(track).id == robot);
}
