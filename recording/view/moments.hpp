// What a viewer asks of a lab's log: the newest messages at a moment, and those of many moments in a row.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "recording/log.hpp"

namespace arkmesh::recording {

// Called with each message's lab time, channel and bytes, in order; false ends it.
using Give = std::function<bool(std::int64_t t_us, const std::string& channel, std::span<const std::byte> message)>;

// The newest message at or before `t_us` of each of these channels; none named: of all. A frame of many robots that was
// split into messages comes whole. False when `give` ended it.
bool give_moment(const Log& log, std::int64_t t_us, const std::vector<std::string>& channels, const Give& give);

struct Row {
  std::int64_t from_us = 0, step_us = 0;
  std::int64_t count = 0;
};
// For each of the moments from_us + k step_us the newest message as above, but each once, and none that a row which
// ends one step before from_us has given.
bool give_row(const Log& log, const Row& row, const std::vector<std::string>& channels, const Give& give);

}  // namespace arkmesh::recording
