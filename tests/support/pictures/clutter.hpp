// Things on arenas that are no robots, drawn on a picture where no robot is.
#pragma once

#include <string>
#include <vector>

#include "tests/support/pictures/robot_pictures.hpp"

namespace arkmesh::tests {

// black discs, white discs, grey discs, coins, caps, rings, screws, LEDs, clips, tape, cables, hands, cups, words,
// lamps, pads
const std::vector<std::string>& clutter_kinds();

// `count` things of one kind, sized as if robots were `robot_px` across, none nearer to a robot than to touch it.
Scene with_clutter(const Scene& scene, const std::string& kind, int count, double robot_px, unsigned seed);

}  // namespace arkmesh::tests
