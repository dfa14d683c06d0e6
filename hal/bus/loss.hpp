// Which counters count losses, and what people should know of them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"

namespace arkmesh::hal {

// Whether a counter of that name counts messages, frames or readings that were lost: exactly if one of the parts
// between its dots is one of the words in loss.cpp. What counts a loss is named so, and nothing else is.
bool is_loss(std::string_view name);

// A sentence for each kind of message of which most were lost in a run, with reason and usual cause. `prefix` stands
// before the arena's own counters. Empty: nothing much was lost.
std::vector<std::string> loss_words(const Counters& counters, const std::string& prefix = {});

// How well cameras followed the robots, in a sentence; empty where none did. `prefix` as above.
std::string tracking_words(const Counters& counters, const std::string& prefix = {});

}  // namespace arkmesh::hal
