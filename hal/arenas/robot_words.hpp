// Robots in sentences for people.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::hal {

// "4, 7-9, 11". At most `most` parts, then "and N more".
std::string in_words(const std::vector<RobotId>& ascending, std::size_t most = 12);
// "3, 17-19 (moving), 40 (not in sight)", the worst reason first; empty for none.
std::string in_words(std::span<const NotStanding> robots);

}  // namespace arkmesh::hal
