// The settings of DHTF, and what is refused.
#include "scenarios/dhtf/settings.hpp"

#include <doctest/doctest.h>

using namespace arkmesh;
using namespace arkmesh::scenarios::dhtf;

namespace {

Settings read(const std::string& text, const std::vector<std::string>& labs = {"roark", "shark"}) {
  const hal::Config config = hal::Config::from_text("[scenario.dhtf]\n" + text, "test.toml");
  const Settings settings = read_settings(config.root().section("scenario").section("dhtf"), labs);
  config.refuse_unknown();
  return settings;
}

std::string refusal(const std::string& text, const std::vector<std::string>& labs = {"roark", "shark"}) {
  try {
    read(text, labs);
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
  return "";
}

const std::string two = "requirements = { roark = [1, 2], shark = [2, 4] }\n";

}  // namespace

TEST_CASE("dhtf settings: defaults are the paper's") {
  // With nothing but requirements, all numbers are those of the paper.
  const Settings s = read(two);
  CHECK(s.sites == 8);
  CHECK(s.corners);
  CHECK(s.types == Types::random);
  CHECK(s.site_radius_m == 0.08);
  CHECK(s.respawn == hal::LabTime(40'000'000));
  CHECK(s.timeouts_s == std::vector<std::int64_t>{30, 40, 60});
  CHECK(s.wall_zone_m == 0.066);
  CHECK(s.nudge_site_m == 0);
  CHECK(s.requirements.at("roark")[0] == 1);
  CHECK(s.requirements.at("shark")[1] == 4);
}

TEST_CASE("dhtf settings: every key is read") {
  // Each key changes its setting.
  const Settings s = read(two +
                          "cells = \"no_corners\"\ntypes = \"half\"\nsites = 12\nsite_radius_m = 0.1\nrespawn_s = 0.5\n"
                          "timeouts_s = [1, 2, 1023]\nwall_zone_m = 0.1\nrepeat_s = 2\nnudge_site_m = 0.001\n");
  CHECK(!s.corners);
  CHECK(s.types == Types::half);
  CHECK(s.sites == 12);
  CHECK(s.site_radius_m == 0.1);
  CHECK(s.respawn == hal::LabTime(500'000));
  CHECK(s.timeouts_s == std::vector<std::int64_t>{1, 2, 1023});
  CHECK(s.wall_zone_m == 0.1);
  CHECK(s.repeat == hal::LabTime(2'000'000));
  CHECK(s.nudge_site_m == 0.001);
  CHECK(read(two + "types = \"easy\"").types == Types::easy);
  CHECK(read(two + "types = \"hard\"").types == Types::hard);
}

TEST_CASE("dhtf settings: bad values are refused by name") {
  // Each wrong value is refused in a sentence that names its key.
  struct Row {
    std::string text, key;
  };
  for (const Row& row : std::vector<Row>{{two + "cells = \"some\"", "cells"},
                                         {two + "types = \"mixed\"", "types"},
                                         {two + "sites = 0", "sites"},
                                         {two + "sites = 17", "sites"},
                                         {two + "cells = \"no_corners\"\nsites = 13", "sites"},
                                         {two + "site_radius_m = -0.08", "site_radius_m"},
                                         {two + "respawn_s = -1", "respawn_s"},
                                         {two + "timeouts_s = [30, 40]", "timeouts_s"},
                                         {two + "timeouts_s = [30, 40.5, 60]", "timeouts_s"},
                                         {two + "timeouts_s = [30, 40, 1024]", "timeouts_s"},
                                         {two + "repeat_s = 0", "repeat_s"},
                                         {two + "site_radius = 0.08", "site_radius"},
                                         {"requirements = { shark = [2, 4] }", "requirements.roark"},
                                         {"requirements = { roark = [1], shark = [2, 4] }", "requirements.roark"},
                                         {"requirements = { roark = [1, 1.5], shark = [2, 4] }", "requirements.roark"},
                                         {"requirements = { roark = [0, 1], shark = [2, 4] }", "requirements.roark"}}) {
    INFO(row.text);
    const std::string sentence = refusal(row.text);
    CHECK(sentence.find("scenario.dhtf." + row.key) != std::string::npos);
    CHECK(sentence.find("test.toml") != std::string::npos);
  }
}

TEST_CASE("dhtf settings: labs that take no part") {
  // Requirements of a lab that is not in the shared world are allowed, so that it can join by one key.
  const std::string three = "requirements = { lynx = [1, 2], roark = [1, 2], shark = [2, 4] }\n";
  CHECK(read(three).requirements.size() == 3);
  CHECK(read(three, {"lynx", "roark", "shark"}).requirements.size() == 3);
  CHECK(refusal(two, {"lynx", "roark", "shark"}).find("requirements.lynx") != std::string::npos);
}
