#include "scenarios/dhtf/fields.hpp"

namespace arkmesh::scenarios::dhtf {

std::string hard_field(const std::string& lab) {
  return "site_hard." + lab;
}

void declare_fields(lab::Lab& lab, const Settings& settings) {
  const auto sites = static_cast<std::size_t>(settings.sites);
  constexpr std::int64_t far_um = 1'000'000'000, many = 1'000'000'000;
  // Decided once, by the owner.
  lab.declare({.name = "site_cell", .length = sites, .low = 0, .high = 15, .owner_only = true, .initial_only = true});
  for (const char* axis : {"site_x_um", "site_y_um"})
    lab.declare(
        {.name = axis, .length = sites, .low = -far_um, .high = far_um, .owner_only = true, .initial_only = true});
  for (const std::string& each : lab.labs())
    lab.declare(
        {.name = hard_field(each), .length = sites, .low = 0, .high = 1, .owner_only = true, .initial_only = true});
  // Decided at every boundary, by the owner.
  lab.declare({.name = "active", .length = sites, .low = 0, .high = 1, .owner_only = true});
  lab.declare({.name = "executed", .length = sites, .low = 0, .high = many, .owner_only = true});
  lab.declare({.name = "executed_by", .length = sites * lab.labs().size(), .low = 0, .high = many, .owner_only = true});
  // Every lab's own.
  lab.declare({.name = "team", .length = sites, .low = 0, .high = many});
}

}  // namespace arkmesh::scenarios::dhtf
