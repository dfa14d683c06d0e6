// Pictures of rooms that differ as real ones do, rendered by the emulator with their truth: cells from black to blown
// out, one lamp that all robots mirror, unlit domes, cameras from webcams to phones, tints, haze, JPEG.
#pragma once

#include <cstdint>

#include "tests/support/pictures/robot_pictures.hpp"

namespace arkmesh::tests {

// `plain`: as labs often are. `strange`: beyond its ranges, as nothing was tuned on. `phone`: a few large robots.
// `webcam`: small pictures by a camera that takes the middle of a green LED for cyan, and of a blue one for azure.
enum class RoomKind { plain, strange, phone, webcam };

// The same seed gives the same picture.
Scene room(RoomKind kind, std::uint64_t seed);

}  // namespace arkmesh::tests
