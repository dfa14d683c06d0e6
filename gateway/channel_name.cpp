// LCM limits a channel to 63 bytes: 15 for the lab, 1 for '/', 47 for the name.
#include "gateway/channel_name.hpp"

#include <algorithm>
#include <cctype>

#include "hal/messages.hpp"

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

std::string exact_pattern(std::string_view channel) {
  std::string pattern;
  for (char c : channel) {
    // Letters and digits must not be escaped: some have a meaning then.
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-') pattern += '\\';
    pattern += c;
  }
  return pattern;
}

}  // namespace arkmesh::gateway
