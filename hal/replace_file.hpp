// Files that are never half written.
#pragma once

#include <filesystem>
#include <string_view>

namespace arkmesh::hal {

// Makes `text` the file's whole content: written beside it, to the disk, and then put in its place. Returns errno, 0
// when that is done; else the file is as it was.
int replace_file(const std::filesystem::path& file, std::string_view text);

}  // namespace arkmesh::hal
