// What a testbed with rovers offers to a computer: a cable to the base station, and a camera that does not know who is
// who.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::examples::rover {

class ByteStream {
 public:
  virtual ~ByteStream() = default;
  // Never blocks; what the device does not take is lost.
  virtual void write(std::span<const std::byte> bytes) = 0;
  // What has come since the last call. Never blocks.
  virtual std::vector<std::byte> read() = 0;
};

struct Spot {
  hal::Pose pose;
  bool lit = false;
};

class SpotCamera {
 public:
  virtual ~SpotCamera() = default;
  // The rovers that are in sight now, in any order.
  virtual std::vector<Spot> look() = 0;
};

}  // namespace arkmesh::examples::rover
