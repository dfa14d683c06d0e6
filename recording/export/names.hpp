// Names from a log, which may be anything, as names of files and of datasets.
#pragma once

#include <string>
#include <string_view>

namespace arkmesh::recording {

// A name as a part of a path: what is no letter, digit, '.', '-' or '_' becomes '_'; a name of dots too.
std::string safe_name(std::string_view name);
// The same of each part of a name with '/'.
std::string safe_path(std::string_view name);

}  // namespace arkmesh::recording
