#include "hal/platforms/kilobot/robot_ids.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "hal/arenas/arena_config.hpp"
#include "hal/counted.hpp"
#include "hal/platforms/kilobot/body.hpp"

namespace arkmesh::hal::kilobot {
namespace {

std::optional<RobotId> number(std::string_view text) {
  RobotId value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return {};
  return value;
}

}  // namespace

std::vector<RobotId> read_robot_ids(const Section& arena, const WordLayout& layout) {
  const RobotId most = largest_id(layout);
  const auto robots = static_cast<std::size_t>(read_arena_config(arena, body_radius_m).robots);
  const Section kilobot = arena.section("kilobot");
  std::vector<RobotId> out;
  for (const std::string& part : kilobot.get("ids", std::vector<std::string>())) {
    const std::size_t dash = part.find('-');
    const auto first = number(std::string_view(part).substr(0, dash));
    const auto last = dash == std::string::npos ? first : number(std::string_view(part).substr(dash + 1));
    if (!first || !last || *first > *last)
      kilobot.refuse("ids", fmt::format("\"{}\" is neither an id nor a range such as \"0-11\"", part));
    if (*last > most)
      kilobot.refuse("ids",
                     fmt::format("{} is above {}, the largest id in the layout {}", *last, most, name_of(layout)));
    for (RobotId id = *first; id <= *last; ++id) out.push_back(id);
  }
  std::ranges::sort(out);
  if (const auto twice = std::ranges::adjacent_find(out); twice != out.end())
    kilobot.refuse("ids", fmt::format("robot {} is listed twice", *twice));
  if (out.empty()) {
    if (robots > most + 1)
      arena.refuse("robots",
                   fmt::format("must be at most {}, the number of ids in the layout {}", most + 1, name_of(layout)));
    for (RobotId id = 0; id < robots; ++id) out.push_back(id);
  } else if (out.size() != robots) {
    kilobot.refuse(
        "ids", fmt::format("lists {}, but arena.robots is {}; make them equal", counted(out.size(), "robot"), robots));
  }
  return out;
}

}  // namespace arkmesh::hal::kilobot
