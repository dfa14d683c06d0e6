// What the rules of a lab make of one channel, in words. Pure.
#pragma once

#include <string>
#include <string_view>

#include "gateway/channel_rules.hpp"

namespace arkmesh::gateway {

// Of what the rules belong to.
struct ExplainedLab {
  std::string name;
  std::string file;  // to be named where something is to be written
  const ChannelRules& rules;
};

struct Explanation {
  bool passes = false;
  std::string text;  // which rule, and with which settings; or why not, and what to write. Lines, each ended
};

// `channel`: its name without a lab's, to or from `peer`.
Explanation explain(const ExplainedLab& lab, Direction way, const std::string& channel, const std::string& peer);

}  // namespace arkmesh::gateway
