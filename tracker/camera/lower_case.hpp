#pragma once

#include <algorithm>
#include <cctype>
#include <string>

namespace arkmesh::tracker {

// ASCII letters in lower case; other bytes stay.
inline std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

}  // namespace arkmesh::tracker
