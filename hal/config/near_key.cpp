// Letters to insert, remove, change or swap (Damerau-Levenshtein with adjacent swaps).
#include "hal/config/near_key.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace arkmesh::hal {

namespace {

std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

}  // namespace

std::optional<std::string> near_key(std::string_view unknown, const std::set<std::string, std::less<>>& known) {
  constexpr std::size_t longest = 200;  // distance() is quadratic; nobody types longer keys
  std::optional<std::string> best;
  std::size_t nearest = std::clamp<std::size_t>(unknown.size() / 5, 1, 3) + 1;
  for (const std::string& key : known) {
    if (std::max(key.size(), unknown.size()) > longest) continue;
    if (const std::size_t d = distance(unknown, key); d < nearest) nearest = d, best = key;
  }
  return best;
}

}  // namespace arkmesh::hal
