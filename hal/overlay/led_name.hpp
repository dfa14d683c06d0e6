// The words for LED colours, as people, tables and JSON read them.
#pragma once

#include <array>

#include "hal/types.hpp"

namespace arkmesh::hal {

inline constexpr std::array<const char*, 9> led_names = {"off",     "red",  "green", "yellow", "blue",
                                                         "magenta", "cyan", "white", "unknown"};

constexpr const char* name_of(Led led) {
  return led_names[static_cast<std::size_t>(led) % led_names.size()];
}

}  // namespace arkmesh::hal
