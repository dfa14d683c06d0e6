// Which channel names may cross labs, and how they are called elsewhere.
#pragma once

#include <string>
#include <string_view>

namespace arkmesh::gateway {

// 1..47 printable ASCII characters, no space and no '/': the origin is in the name, so names with '/' are foreign
// already.
bool is_exported_name(std::string_view channel);
// "roark" and "world" give "roark/world".
std::string foreign_name(std::string_view lab, std::string_view channel);
// The LCM pattern that matches this name and nothing else.
std::string exact_pattern(std::string_view channel);

}  // namespace arkmesh::gateway
