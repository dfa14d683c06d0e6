// What a scenario shows people (hal/drawing) as parts of Foxglove's 3D scene, flat on the floor. Patterns are left out:
// the scene has none.
#pragma once

#include "hal/overlay/drawing.hpp"
#include "recording/export/scene_parts.hpp"

namespace arkmesh::recording::scene {

// In the colours for dark grounds. A raster of many cells becomes a coarser one, and fills of polygons with more than
// 64 corners are left out, so that a message stays small.
void draw(foxglove::SceneEntity& to, const hal::Drawing& drawing);

}  // namespace arkmesh::recording::scene
