// Which counters count losses.
#pragma once

#include <string_view>

namespace arkmesh::hal {

// Whether a counter of that name counts messages, frames or readings that were lost: exactly if one of the parts
// between its dots is one of the words in loss.cpp. What counts a loss is named so, and nothing else is.
bool is_loss(std::string_view name);

}  // namespace arkmesh::hal
