// The settings of CRE, what is refused, and what is sent to robots of them.
#include "scenarios/cre/settings.hpp"

#include <doctest/doctest.h>

#include "scenarios/cre/controller/cre_messages.h"

using namespace arkmesh;
namespace cre = scenarios::cre;

namespace {

cre::Settings read_cre(const std::string& text, const std::vector<std::string>& labs = {"high", "low"}) {
  const hal::Config config = hal::Config::from_text("[scenario.cre]\n" + text, "test.toml");
  const cre::Settings settings = cre::read_settings(config.root().section("scenario").section("cre"), labs);
  config.refuse_unknown();
  return settings;
}

std::string cre_refusal(const std::string& text, const std::vector<std::string>& labs = {"high", "low"}) {
  try {
    read_cre(text, labs);
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
  return "";
}

const std::string roles = "roles = { ground = \"low\", flying = \"high\" }\n";

}  // namespace

TEST_CASE("cre settings: defaults are the paper's") {
  // With nothing but roles, all numbers are those of preset paper.
  const cre::Settings s = read_cre(roles);
  CHECK(s.roles.ground == "low");
  CHECK(s.roles.flying == "high");
  CHECK(s.resources_north == 10);
  CHECK(s.resources_south == 35);
  CHECK(s.hear_radius_m == 0.20);
  CHECK(s.abandon == 0.01);
  CHECK(s.straight == hal::LabTime(3'000'000));
  CHECK(!s.decide_together);
  const hal::Config preset =
      hal::Config::from_file(std::filesystem::path(ARKMESH_SOURCE_DIR) / "experiments/cre/sky.toml");
  const cre::Settings paper = cre::read_settings(preset.root().section("scenario").section("cre"), {"meadow", "sky"});
  CHECK(cre::rules_of(paper).data == cre::rules_of(s).data);
  CHECK(paper.hear_radius_m == s.hear_radius_m);
}

TEST_CASE("cre settings: roles are of any lab") {
  // Whichever names labs have, each plays what the configuration says.
  CHECK(read_cre("roles = { ground = \"high\", flying = \"low\" }").roles.flying == "low");
}

TEST_CASE("cre settings: bad values are refused by name") {
  // Each wrong value is refused in a sentence that names its key and says what to do.
  struct Row {
    std::string text, key, sentence;
  };
  for (const Row& row : std::vector<Row>{
           {"", "roles.ground", "is missing: name the lab that plays the ground swarm"},
           {"roles = { ground = \"low\" }", "roles.flying", "is missing"},
           {"roles = { ground = \"low\", flying = \"sky\" }", "roles.flying",
            "sky is no lab of shared.labs (high, low)"},
           {"roles = { ground = \"low\", flying = \"low\" }", "roles.flying", "already plays the ground swarm"},
           {"roles = { ground = \"low\", flying = \"high\", diving = \"low\" }", "roles.diving", "unknown key"},
           {roles + "resources_north = 50", "resources_north", "use at most 49"},
           {roles + "resources_north = 1\nresources_south = 8\ngrid = 4", "resources_south", "8 places in each region"},
           {roles + "resources_south = 60\nresources_north = 60", "resources_north", "use at most 49"},
           {roles + "grid = 5", "grid", "use an even number"},
           {roles + "grid = 0", "grid", "between 2 and 100"},
           {roles + "abandon = 0.31", "abandon", "between 0 and 0.3"},
           {roles + "recruit = 1.1", "recruit", "between 0 and 1"},
           {roles + "weight = 0", "weight", "between"},
           {roles + "decision_s = 26", "decision_s", "between"},
           {roles + "straight_s = 26", "straight_s", "between"},
           {roles + "sense_s = 0", "sense_s", "between"},
           {roles + "hear_radius_m = -0.2", "hear_radius_m", "between"},
           {roles + "resource_radius = 0.02", "resource_radius", "did you mean"}}) {
    INFO(row.text);
    const std::string sentence = cre_refusal(row.text);
    CHECK(sentence.find("scenario.cre." + row.key) != std::string::npos);
    CHECK(sentence.find(row.sentence) != std::string::npos);
  }
  CHECK(cre_refusal(roles, {"high", "low", "third"}).find("give lab third no role") != std::string::npos);
}

TEST_CASE("cre settings: what is sent to robots") {
  // Every rate arrives in the unit in which robots read it.
  const cre::Settings s = read_cre(roles +
                                   "commit = 0.2\nrecruit = 0.8\nweight = 0.65\nabandon = 0.3\ndecision_s = 10.3\n"
                                   "straight_s = 25.5\ndecide_together = true\nsay_once = true\n");
  const hal::FleetCommand rules = cre::rules_of(s);
  CHECK(rules.kind == hal::FleetCommand::Kind::broadcast);
  CHECK(rules.type == CRE_TYPE_RULES);
  CHECK(rules.data ==
        std::array<std::uint8_t, 9>{50, 200, 163, 3000 >> 8, 3000 & 255, 103, CRE_TOGETHER | CRE_SAY_ONCE, 255, 0});
  CHECK(cre::rules_of(read_cre(roles + "ignore_zeros = true")).data[CRE_RULE_FLAGS] == CRE_IGNORE_ZERO);
  CHECK(cre::rules_of(read_cre(roles + "abandon = 0")).data[CRE_RULE_ABANDON + 1] == 0);
}
