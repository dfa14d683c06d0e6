// One program drives an overhead controller at a time: a lock for each port's name, on this machine, for devices and
// for tcp:// alike. It ends with the process that holds it, whatever happens to that.
#pragma once

#include <memory>
#include <string>

#include "hal/handle.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"

namespace arkmesh::hal::kilobot {

class PortLock {
 public:
  // `who`: named to others that want the port, such as "lab shark". A guard (StandGuard) that has the port gives way at
  // once. Throws PortError when another program has it.
  PortLock(const std::string& port, const std::string& who);

 private:
  Handle file_;
};

// A stream to what find_line() takes, for this program alone for as long as it lives. Throws PortError.
std::unique_ptr<ByteStream> claim_byte_stream(const std::string& port, const std::string& who);

}  // namespace arkmesh::hal::kilobot
