// Two numbers of one word of the command line, such as 1x0.5 or 0.2,-0.1.
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <utility>

namespace arkmesh::cli {

// Empty when `text` is not two numbers with `between` between them and nothing else.
inline std::optional<std::pair<double, double>> two_numbers(const std::string& text, char between) {
  double first = 0, second = 0;
  char separator = 0, rest = 0;
  if (std::sscanf(text.c_str(), "%lf%c%lf%c", &first, &separator, &second, &rest) != 3 || separator != between)
    return {};
  return std::pair(first, second);
}

}  // namespace arkmesh::cli
