// The event loop of a process: everything that waits, waits on it. Named here without what it brings, so that only
// sources that put something on it compile Asio.
#pragma once

namespace boost::asio {
class io_context;
}

namespace arkmesh::hal {

using EventLoop = boost::asio::io_context;

}  // namespace arkmesh::hal
