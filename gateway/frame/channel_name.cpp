// LCM limits a channel to 63 bytes: 15 for the lab, 1 for '/', 47 for the name.
#include "gateway/frame/channel_name.hpp"

#include <algorithm>
#include <cctype>

#include "hal/arenas/messages.hpp"

namespace arkmesh::gateway {

bool is_exported_name(std::string_view channel) {
  return !channel.empty() && channel.size() <= hal::max_channel_name &&
         std::ranges::all_of(channel, [](char c) { return c > ' ' && c <= '~' && c != '/'; });
}

std::string foreign_name(std::string_view lab, std::string_view channel) {
  std::string name(lab);
  name += '/';
  name += channel;
  return name;
}

bool commands_robots(std::string_view channel) {
  return channel == "operator_command" || channel == hal::channel::fleet_command || channel == hal::channel::to_robots;
}

bool has_wildcard(std::string_view pattern) {
  return pattern.find('*') != std::string_view::npos;
}

// Goes back to the last star only: what an earlier one would take, that one can take as well.
bool matches(std::string_view pattern, std::string_view channel) {
  std::size_t p = 0, c = 0, after_star = std::string_view::npos, taken_to = 0;
  while (c < channel.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      after_star = ++p;
      taken_to = c;
    } else if (p < pattern.size() && pattern[p] == channel[c]) {
      ++p;
      ++c;
    } else if (after_star != std::string_view::npos) {
      p = after_star;
      c = ++taken_to;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

std::string lcm_pattern(std::string_view pattern) {
  std::string out;
  for (char c : pattern) {
    // Letters and digits must not be escaped: some have a meaning then.
    if (c == '*')
      out += "[^/]*";
    else if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-')
      (out += '\\') += c;
    else
      out += c;
  }
  return out;
}

}  // namespace arkmesh::gateway
