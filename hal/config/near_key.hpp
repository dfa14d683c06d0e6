// Which known key an unknown one was probably meant to be.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace arkmesh::hal {

// Near: few letters wrong. Keys are dotted.
std::optional<std::string> near_key(std::string_view unknown, const std::set<std::string, std::less<>>& known);

}  // namespace arkmesh::hal
