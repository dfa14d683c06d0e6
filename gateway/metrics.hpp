// What a gateway says of its peers, as Prometheus reads it (its text format, version 0.0.4). Pure.
#pragma once

#include <string>

#include "arkmesh/peers_t.hpp"

namespace arkmesh::gateway {

// One line for each value; labels tell lab, peer, channel, and the counter's name as in `peers`. Text of peers is
// escaped.
std::string to_metrics(const peers_t& peers);

}  // namespace arkmesh::gateway
