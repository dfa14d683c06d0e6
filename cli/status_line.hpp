// The name that commands with work in words used for the line before it implemented hal::Progress.
#pragma once

#include "cli/progress_line.hpp"

namespace arkmesh::cli {

using StatusLine = ProgressLine;

}  // namespace arkmesh::cli
