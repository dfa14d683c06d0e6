// Blue and magenta told apart by the other robots of a picture: cameras see the two at hues that differ from table to
// table, but one camera sees all robots' LEDs alike.
#pragma once

#include <span>

#include "tracker/detect/detection.hpp"

namespace arkmesh::tracker {

// Where lit LEDs between cyan and red form groups of hue with gaps between them, a group of two robots or more has one
// colour, that of its median; a border through a group is moved into the gap beside it. A robot whose hue stands alone
// keeps what its own light says. `robots` are those of one picture.
void judge_beside_others(std::span<Detection*> robots);

}  // namespace arkmesh::tracker
