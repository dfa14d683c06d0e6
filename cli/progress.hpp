// The name that commands with counted work used for the line before it implemented hal::Progress.
#pragma once

#include "cli/progress_line.hpp"

namespace arkmesh::cli {

using Progress = ProgressLine;

}  // namespace arkmesh::cli
