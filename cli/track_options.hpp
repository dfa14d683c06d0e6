// The options of `arkmesh track`.
#pragma once

#include "testbed/track_stream.hpp"

namespace CLI {
class App;
}

namespace arkmesh::cli {

// `options` outlives the command.
void add_track_options(CLI::App& command, testbed::StreamOptions& options);

}  // namespace arkmesh::cli
