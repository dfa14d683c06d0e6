// A drawing as the message `overlay`, and back.
#pragma once

#include <cstddef>
#include <span>

#include "arkmesh/overlay_t.hpp"
#include "hal/counters.hpp"
#include "hal/overlay/drawing.hpp"

namespace arkmesh::hal {

overlay_t to_message(const Drawing& drawing, LabTime stamp);

// Reads bytes from outside; sizes are checked before anything is decoded. What is wrong is left out and counted as
// "overlay.refused.<reason>": a whole message (as read_message's), or one shape (as Drawing::add's). False
// when there was no whole message; `drawing` is as it was then.
bool read_overlay(std::span<const std::byte> bytes, Drawing& drawing, Counters& refused);

}  // namespace arkmesh::hal
