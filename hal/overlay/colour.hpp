// Colours by meaning: what a scenario draws says what it is, and each picture of it (page, camera, film) how that
// looks. The table is view/page/colours.json; the build makes colour_table.hpp from it.
#pragma once

#include <cstdint>
#include <string_view>

#include "colour_table.hpp"

namespace arkmesh::hal {

// The table's names, e.g. Colour::site_active.
enum class Colour : std::uint8_t {
#define ARKMESH_COLOUR(name, light, dark, pattern) name,
  ARKMESH_COLOURS(ARKMESH_COLOUR)
#undef ARKMESH_COLOUR
};

// What lies over a filled shape, so that nothing is told by colour alone: nothing, lines that rise to the right, dots,
// lines both ways.
enum class Pattern : std::uint8_t { plain, stripes, dots, cross };

struct ColourLook {
  std::string_view name;
  Colour colour;
  std::uint32_t light, dark;  // 0xrrggbb on light grounds; on dark ones and over pictures
  Pattern pattern;
};

inline constexpr ColourLook colour_looks[] = {
#define ARKMESH_COLOUR(name, light, dark, pattern) {#name, Colour::name, light, dark, Pattern::pattern},
    ARKMESH_COLOURS(ARKMESH_COLOUR)
#undef ARKMESH_COLOUR
};
inline constexpr double fill_opacity = ARKMESH_FILL_OPACITY;      // of a filled shape
inline constexpr double raster_opacity = ARKMESH_RASTER_OPACITY;  // of a raster's cell of 255

constexpr const ColourLook& look_of(Colour colour) {
  return colour_looks[static_cast<std::size_t>(colour)];
}
// Colour::note for a name that the table does not have, such as one of a newer version.
constexpr Colour colour_named(std::string_view name) {
  for (const ColourLook& look : colour_looks)
    if (look.name == name) return look.colour;
  return Colour::note;
}

}  // namespace arkmesh::hal
