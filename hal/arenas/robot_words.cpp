#include "hal/arenas/robot_words.hpp"

#include <fmt/format.h>

#include <utility>

namespace arkmesh::hal {

std::string in_words(const std::vector<RobotId>& ascending, std::size_t most) {
  std::string out;
  std::size_t parts = 0;
  for (std::size_t i = 0; i < ascending.size(); ++parts) {
    if (parts == most) return out + fmt::format(" and {} more", ascending.size() - i);
    std::size_t last = i;
    while (last + 1 < ascending.size() && ascending[last + 1] == ascending[last] + 1) ++last;
    if (last == i + 1) last = i;
    if (!out.empty()) out += ", ";
    out += last == i ? fmt::format("{}", ascending[i]) : fmt::format("{}-{}", ascending[i], ascending[last]);
    i = last + 1;
  }
  return out;
}

std::string in_words(std::span<const NotStanding> robots) {
  using Why = NotStanding::Why;
  static constexpr std::pair<Why, const char*> reasons[] = {{Why::moving, "moving"},
                                                            {Why::not_in_sight, "not in sight"},
                                                            {Why::not_named, "never identified"},
                                                            {Why::not_told, "not sent yet"},
                                                            {Why::not_yet, "still watched"}};
  std::string out;
  for (const auto& [why, words] : reasons) {
    std::vector<RobotId> of_these;
    for (const NotStanding& robot : robots)
      if (robot.why == why) of_these.push_back(robot.robot);
    if (!of_these.empty()) out += fmt::format("{}{} ({})", out.empty() ? "" : ", ", in_words(of_these), words);
  }
  return out;
}

}  // namespace arkmesh::hal
