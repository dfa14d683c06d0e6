// See explanation.hpp.
#include "tracker/detect/explanation.hpp"

#include <algorithm>
#include <cmath>

namespace arkmesh::tracker {

constexpr std::size_t max_objections = 60;

void thin_out(Explanation& explanation, const std::vector<Detection>& robots) {
  auto& others = explanation.not_found;
  std::stable_sort(others.begin(), others.end(),
                   [](const auto& a, const auto& b) { return a.confidence > b.confidence; });
  double r_px = robots.empty() ? 0 : robots[0].r_px;
  if (r_px == 0 && !explanation.sizes.empty()) r_px = explanation.sizes[0].r_px;
  std::vector<Circle> taken;
  for (const Detection& one : robots) taken.push_back({one.x_px, one.y_px, one.r_px});
  std::erase_if(others, [&](const Explanation::NotFound& one) {
    const Circle& at = one.circle;
    if (taken.size() >= robots.size() + max_objections || (r_px > 0 && std::abs(std::log(at.r_px / r_px)) > 0.25) ||
        std::any_of(taken.begin(), taken.end(), [&](const Circle& other) {
          return std::hypot(other.x_px - at.x_px, other.y_px - at.y_px) < std::max(other.r_px, at.r_px);
        }))
      return true;
    taken.push_back(at);
    return false;
  });
}

}  // namespace arkmesh::tracker
