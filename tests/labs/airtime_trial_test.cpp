// What labs would say is tried in simulation whatever arena they use, and compared with that arena's airtime.
#include "app/airtime_trial.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "tests/support/labs/dhtf_configs.hpp"

using namespace arkmesh;

namespace {

std::vector<app::AirtimeNeed> tried(const std::vector<std::string>& sets) {
  const auto folder = tests::experiments() / "dhtf";
  return app::try_airtime({{folder / "shark.toml", folder / "roark.toml"}, sets}, 10, hal::nobody_stops(), nullptr);
}

}  // namespace

TEST_CASE("a trial counts each slot's words beside the room of the arena in use") {
  const std::vector<app::AirtimeNeed> needs =
      tried({"shark:arena.use=\"kilobot\"", "shark:arena.kilobot.spacing_s=0.1", "arena.robots=20"});
  REQUIRE(needs.size() == 2);
  CHECK(needs[0].lab == "shark");
  CHECK(needs[0].robots == 20);
  CHECK(needs[0].layout == "ark");
  CHECK(needs[0].room == doctest::Approx(30));
  CHECK(needs[1].room == doctest::Approx(3 / 0.055));
  for (const app::AirtimeNeed& need : needs) {
    CHECK(need.seconds == 10);
    REQUIRE(need.slots.size() == 1);
    const app::SlotNeed& slot = need.slots.at(0);
    CHECK(slot.words > 0);
    CHECK(slot.words == need.all.words);
    CHECK(slot.in_one_s <= slot.words);
    CHECK(slot.in_one_s * 10 >= slot.words);
    CHECK(need.air.refused == 0);
    CHECK(need.air.offered == need.all.words);
    CHECK(need.anew % 3 == 0);
    CHECK(need.anew > 0);
    CHECK(need.anew <= 20 * 3);
  }
}

TEST_CASE("an arena that carries no messages has no airtime") {
  try {
    tried({"arena.use=\"null\""});
    FAIL("was tried");
  } catch (const hal::ConfigError& error) {
    CHECK(std::string(error.what()).find("arena.use = \"null\": has no airtime to report") != std::string::npos);
  }
}
