#include "scenarios/cre/fields.hpp"

namespace arkmesh::scenarios::cre {

void declare_fields(lab::Lab& lab, const Settings& settings) {
  const auto places = static_cast<std::size_t>(settings.grid) * static_cast<std::size_t>(settings.grid);
  constexpr std::int64_t far_um = 1'000'000'000, many = 1'000'000'000;
  // The ground lab's alone, though any lab may declare them: others are not read.
  lab.declare({.name = "ground_um", .length = 2, .low = 1, .high = far_um, .initial_only = true});
  lab.declare({.name = "active", .length = places, .low = 0, .high = 1});
  lab.declare({.name = "harvested", .length = 2, .low = 0, .high = many});
}

}  // namespace arkmesh::scenarios::cre
