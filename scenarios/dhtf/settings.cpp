#include "scenarios/dhtf/settings.hpp"

#include <fmt/format.h>

#include <cmath>

namespace arkmesh::scenarios::dhtf {
namespace {

// At most what one message to a robot carries.
constexpr int longest_timeout_s = 1023;

hal::LabTime duration(const hal::Section& section, std::string_view key, hal::LabTime otherwise, double low_s) {
  const double seconds = section.number(key, static_cast<double>(otherwise.count()) * 1e-6, {low_s, 1e6});
  return hal::LabTime(std::llround(seconds * 1e6));
}

Types read_types(const hal::Section& section) {
  const std::string name = section.choice("types", "random", {"random", "half", "easy", "hard"});
  if (name == "half") return Types::half;
  if (name == "easy") return Types::easy;
  if (name == "hard") return Types::hard;
  return Types::random;
}

std::array<int, 3> read_timeouts(const hal::Section& section, const std::array<int, 3>& otherwise) {
  const std::vector<double> seconds =
      section.numbers("timeouts_s", {otherwise.begin(), otherwise.end()}, {1, longest_timeout_s});
  if (seconds.size() != 3)
    section.refuse("timeouts_s", "needs three numbers: easy in all labs, hard in some, hard in all");
  std::array<int, 3> timeouts{};
  for (std::size_t i = 0; i < 3; ++i) {
    if (seconds[i] != std::floor(seconds[i])) section.refuse("timeouts_s", "robots are told whole seconds only");
    timeouts[i] = static_cast<int>(seconds[i]);
  }
  return timeouts;
}

Requirement read_requirement(const hal::Section& requirements, const std::string& lab) {
  const std::vector<double> robots = requirements.numbers(lab, {}, {1, 1000});
  const auto whole = [](double n) { return n == std::floor(n); };
  if (robots.size() != 2 || !whole(robots[0]) || !whole(robots[1]))
    requirements.refuse(lab,
                        fmt::format("say how many robots of lab {0} an easy and a hard task need: {0} = [1, 2]", lab));
  return {.easy = static_cast<int>(robots[0]), .hard = static_cast<int>(robots[1])};
}

}  // namespace

Settings read_settings(const hal::Section& section, const std::vector<std::string>& labs) {
  Settings s;
  s.corners = section.choice("cells", "all", {"all", "no_corners"}) == "all";
  s.sites = static_cast<int>(section.integer("sites", s.sites, 1, 16));
  if (!s.corners && s.sites > 12)
    section.refuse("sites", "only 12 of the 16 cells are no corners; use fewer sites or cells = \"all\"");
  s.types = read_types(section);
  s.site_radius_m = section.number("site_radius_m", s.site_radius_m, {0.001, 100});
  s.respawn = duration(section, "respawn_s", s.respawn, 0);
  s.timeouts_s = read_timeouts(section, s.timeouts_s);
  s.wall_zone_m = section.number("wall_zone_m", s.wall_zone_m, {0, 100});
  s.repeat = duration(section, "repeat_s", s.repeat, 0.01);
  s.nudge_site_m = section.number("nudge_site_m", s.nudge_site_m, {-1, 1});

  // Labs that take no part may have requirements there too.
  section.names_below("requirements");
  const hal::Section requirements = section.section("requirements");
  for (const std::string& lab : labs) s.requirements.emplace(lab, read_requirement(requirements, lab));
  return s;
}

}  // namespace arkmesh::scenarios::dhtf
