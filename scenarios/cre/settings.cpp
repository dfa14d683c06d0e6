#include "scenarios/cre/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenarios/cre/controller/cre_messages.h"

namespace arkmesh::scenarios::cre {
namespace {

// A share, in steps of 1/`one`.
unsigned in_steps(double share, int one) {
  return static_cast<unsigned>(std::lround(share * one));
}

std::uint8_t in_tenths(hal::LabTime t) {
  return static_cast<std::uint8_t>((t.count() + 50'000) / 100'000);
}

}  // namespace

void Roles::fields(const hal::Section& roles) {
  roles.field("ground", ground, {.help = "the lab whose robots harvest; it owns the resources", .sample = "\"lab\""});
  roles.field("flying", flying, {.help = "the lab whose robots sense both regions", .sample = "\"other\""});
}

void Settings::fields(const hal::Section& cre) {
  cre.field("roles", roles);
  cre.field("grid", grid,
            {.range = {2, 100}, .unit = "places", .help = "places in each row and column of the ground arena; even"});
  cre.field("resources_north", resources_north,
            {{0, 1e4}, "places", "resources in the north that are active at any time"});
  cre.field("resources_south", resources_south,
            {{0, 1e4}, "places", "resources in the south that are active at any time"});
  cre.field("resource_radius_m", resource_radius_m, {{0.001, 100}, "m", "ground robots within this distance harvest"});
  cre.field("sense_radius_m", sense_radius_m,
            {{0.001, 100}, "m", "radius of a flying robot's sensor, in metres of the flying arena"});
  cre.field("sense_s", sense, {{0.1, 1e3}, "s", "interval between readings of a flying robot's sensor"});
  cre.field("hear_radius_m", hear_radius_m,
            {{0.001, 100}, "m", "range at which a ground robot hears a flying one, in metres of the ground arena"});
  cre.field("wall_zone_m", wall_zone_m, {{0, 100}, "m", "robots sense walls within this distance"});
  cre.field("repeat_s", repeat, {{0.1, 1e3}, "s", "interval between equal messages to a ground robot"});
  cre.field("commit", commit, {.range = {0, 1}, .help = "h: an uncommitted robot commits with probability h v"});
  cre.field(
      "recruit", recruit,
      {.range = {0, 1}, .help = "k: recruitment and cross-inhibition, with probability k v of the sender's region"});
  cre.field("abandon", abandon,
            {.range = {0, 0.3}, .help = "a: a committed robot gives up with probability a / v; 0: never"});
  cre.field("weight", weight, {.range = {0.004, 1}, .help = "w: weight of each reading in the estimate v"});
  cre.field("decision_s", decision, {{0.1, 25.5}, "s", "interval between decisions of a flying robot"});
  cre.field("straight_s", straight,
            {{0.1, 25.5}, "s", "time for which a ground robot moves straight after hearing a flying one"});
  cre.field("decide_together", decide_together,
            {.help = "all flying robots decide at the same time; otherwise each has its own phase"});
  cre.field("ignore_zeros", ignore_zeros, {.help = "exclude readings of zero from the estimate"});
  cre.field("say_once", say_once,
            {.help = "a flying robot sends its opinion once for each decision; otherwise twice a second"});
  cre.field("rules_repeat_s", rules_repeat, {{1, 1e6}, "s", "interval at which robots are sent their rules"});
  cre.field("consensus", consensus, {.range = {0.5, 1}, .help = "share of the flying robots that counts as consensus"});
}

void Settings::check(const hal::Section& cre) const {
  if (grid % 2 != 0) cre.refuse("grid", "is odd, so that a row of places lies on the border; use an even number");
  const int places = grid * grid / 2;
  const auto fit = [&](const char* key, int resources) {
    if (resources < places) return;
    cre.refuse(key, fmt::format("a grid of {0} x {0} has {1} places in each region, of which one must be free for the "
                                "next resource; use at most {2}, or a larger scenario.cre.grid",
                                grid, places, places - 1));
  };
  fit("resources_north", resources_north);
  fit("resources_south", resources_south);
}

Settings read_settings(const hal::Section& cre, const std::vector<std::string>& labs) {
  const auto settings = cre.read<Settings>();
  const Roles& roles = settings.roles;
  for (const auto& [role, lab] : {std::pair{"ground", roles.ground}, {"flying", roles.flying}}) {
    const std::string key = fmt::format("roles.{}", role);
    if (lab.empty()) cre.refuse(key, fmt::format("is missing: name the lab that plays the {} swarm", role));
    if (std::ranges::find(labs, lab) == labs.end())
      cre.refuse(key, fmt::format("{} is no lab of shared.labs ({})", lab, fmt::join(labs, ", ")));
  }
  if (roles.ground == roles.flying)
    cre.refuse("roles.flying", fmt::format("lab {} already plays the ground swarm; name another lab", roles.ground));
  for (const std::string& lab : labs)
    if (lab != roles.ground && lab != roles.flying)
      cre.refuse("roles", fmt::format("give lab {} no role: CRE has one ground and one flying swarm; take it out of "
                                      "shared.labs",
                                      lab));
  return settings;
}

hal::FleetCommand rules_of(const Settings& s) {
  hal::FleetCommand rules{.kind = hal::FleetCommand::Kind::broadcast, .type = CRE_TYPE_RULES};
  const unsigned abandon = in_steps(s.abandon, CRE_ABANDON_ONE);
  rules.data[CRE_RULE_COMMIT] = static_cast<std::uint8_t>(in_steps(s.commit, CRE_ONE));
  rules.data[CRE_RULE_RECRUIT] = static_cast<std::uint8_t>(in_steps(s.recruit, CRE_ONE));
  rules.data[CRE_RULE_WEIGHT] = static_cast<std::uint8_t>(in_steps(s.weight, CRE_ONE));
  rules.data[CRE_RULE_ABANDON] = static_cast<std::uint8_t>(abandon >> 8);
  rules.data[CRE_RULE_ABANDON + 1] = static_cast<std::uint8_t>(abandon & 255);
  rules.data[CRE_RULE_DECISION] = in_tenths(s.decision);
  rules.data[CRE_RULE_FLAGS] =
      static_cast<std::uint8_t>((s.decide_together ? CRE_TOGETHER : 0) | (s.ignore_zeros ? CRE_IGNORE_ZERO : 0) |
                                (s.say_once ? CRE_SAY_ONCE : 0));
  rules.data[CRE_RULE_STRAIGHT] = in_tenths(s.straight);
  return rules;
}

}  // namespace arkmesh::scenarios::cre
