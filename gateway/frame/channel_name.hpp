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
// What robots obey. Who means these channels names them: no '*' that allows does.
bool commands_robots(std::string_view channel);
// Whether the name is what the pattern says, in which each '*' stands for any characters, or none.
bool matches(std::string_view pattern, std::string_view channel);
bool has_wildcard(std::string_view pattern);
// The LCM pattern that matches the same names that can be exported, and nothing else.
std::string lcm_pattern(std::string_view pattern);

}  // namespace arkmesh::gateway
