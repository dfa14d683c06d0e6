// Stands for a measure of the robots, which whoever uses the tracker gives: it knows none of its own.
#pragma once

#include <limits>

namespace arkmesh::tracker {

inline constexpr double not_given = std::numeric_limits<double>::quiet_NaN();

}  // namespace arkmesh::tracker
