// A file as one text, when it is a regular one of a size that can be expected: a folder from elsewhere may hold pipes,
// devices and endless files under any name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace arkmesh::hal {

// Nothing when there is no such file, or it is none of that kind, or it cannot be read.
std::optional<std::string> whole_file(const std::filesystem::path& file, std::uintmax_t max_bytes);

}  // namespace arkmesh::hal
