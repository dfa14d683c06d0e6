// A count of a scenario as people read it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace arkmesh::app {

// "flying south 97.5 %" of flying.south_ppm and 975000: the last word of a name may be a unit, ppm (shown as %), us, ms
// or s (as seconds), or bytes (as kB). As view/page/words.js. A `label` takes the place of the words.
std::string count_words(std::string_view name, std::uint64_t n, std::string_view label = {});

}  // namespace arkmesh::app
