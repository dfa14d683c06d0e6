// A testbed's devices, and the arena made of them, with everything that passes them noted in a record. They behave as
// without it. A null record leaves each as it is.
#pragma once

#include <memory>

#include "hal/arenas/arena.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"
#include "testbed/arena_monitor.hpp"
#include "testbed/raw_record.hpp"
#include "tracker/camera/live_camera.hpp"

namespace arkmesh::testbed {

// What a guard's process says after the lab's death is not in it.
std::unique_ptr<hal::kilobot::ByteStream> recorded(std::unique_ptr<hal::kilobot::ByteStream> stream,
                                                   std::shared_ptr<RawRecord> record);
// Cameras are numbered as they are opened.
tracker::OpenCamera recorded(tracker::OpenCamera open, std::shared_ptr<RawRecord> record);
// `observer` may be empty.
Observer recorded(Observer observer, std::shared_ptr<RawRecord> record);
// Begins the record when the arena is first asked to go on: from then on a run's folder is the run's own.
std::unique_ptr<hal::Arena> recorded(std::unique_ptr<hal::Arena> arena, std::shared_ptr<RawRecord> record);

}  // namespace arkmesh::testbed
