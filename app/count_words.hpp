// A count of a scenario as people read it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace arkmesh::app {

// "flying south 97.5 %" of flying.south_ppm and 975000: the last word of a name may be a unit, ppm (shown as %), us, ms
// or s (as seconds), or bytes (as kB). As view/page/words.js.
std::string count_words(std::string_view name, std::uint64_t n);

}  // namespace arkmesh::app
