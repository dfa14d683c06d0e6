#include "hal/loss.hpp"

#include <algorithm>
#include <array>

namespace arkmesh::hal {

bool is_loss(std::string_view name) {
  static constexpr std::array<std::string_view, 13> words{"dropped",  "expired", "gap",     "ignored",  "late",
                                                          "lost",     "missing", "refused", "not_sent", "not_recorded",
                                                          "replaced", "skipped", "withheld"};
  while (!name.empty()) {
    const auto end = std::min(name.find('.'), name.size());
    if (std::ranges::find(words, name.substr(0, end)) != words.end()) return true;
    name.remove_prefix(std::min(end + 1, name.size()));
  }
  return false;
}

}  // namespace arkmesh::hal
