// The link as the original knows it: plain TCP. As the server it listens while nobody is connected and takes one; as
// the client it tries again and again, since the original server listens while it starts and takes one only.
#pragma once

#include <memory>

#include "hal/event_loop.hpp"
#include "mark/link.hpp"
#include "mark/settings.hpp"

namespace arkmesh::mark {

// `loop` outlives the link.
std::unique_ptr<Link> make_tcp_link(hal::EventLoop& loop, const Settings& settings, Role role);

}  // namespace arkmesh::mark
