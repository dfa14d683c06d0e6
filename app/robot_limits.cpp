#include "app/robot_limits.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "lab/exchange/state_rules.hpp"
#include "lab/exchange/world_message.hpp"

namespace arkmesh::app {

void check_robot_limits(const hal::Section& root, const lab::RunConfig& run, const CatalogueEntry& scenario,
                        const hal::ArenaInfo& arena, const std::map<std::string, std::string, std::less<>>& settings) {
  const auto with_id_to = [&](hal::RobotId id) {
    return std::ranges::upper_bound(arena.robots, id) - arena.robots.begin();
  };
  if (!arena.robots.empty() && arena.robots.back() > arena.max_robot) {
    const std::string sentence = fmt::format("ids above {} cannot be addressed individually; {} of the {} robots can",
                                             arena.max_robot, with_id_to(arena.max_robot), arena.robots.size());
    if (scenario.addresses_robots)
      root.refuse("arena.robots", fmt::format("{}. Scenario {} addresses robots individually; use at most {} robots",
                                              sentence, scenario.name, with_id_to(arena.max_robot)));
    spdlog::warn("{}: {}", run.lab, sentence);
  }
  if (scenario.kinds > arena.kinds || scenario.values > arena.values)
    root.refuse(
        arena.id_bits > 0 ? "arena.kilobot.layout" : "arena.use",
        fmt::format(
            "has room for kinds up to {} and values up to {}, but scenario {} sends kinds up to {} and values up to {}",
            arena.kinds - 1, arena.values - 1, scenario.name, scenario.kinds - 1, scenario.values - 1));
  if (run.labs.size() == 1) return;
  if (!arena.robots.empty() && arena.robots.back() > lab::max_shared_robot)
    root.refuse("arena.robots", fmt::format("labs can exchange ids up to {} only; use at most {} robots",
                                            lab::max_shared_robot, with_id_to(lab::max_shared_robot)));

  lab::LabState state{.robots = {}, .fields = {}, .settings = settings};
  state.fields[lab::arena_rule().name] = lab::arena_values(arena);
  const auto bytes_with = [&](std::size_t robots) {
    state.robots.resize(robots);
    return lab::longest_message(run, state, arena.can_wait);
  };
  // A sixteenth is for the scenario's fields, which nobody knows yet.
  const std::size_t limit = run.max_message_bytes - run.max_message_bytes / 16, none = bytes_with(0),
                    each = bytes_with(1) - none, fit = limit < none ? 0 : (limit - none) / each;
  if (arena.robots.size() > fit)
    root.refuse("arena.robots", fmt::format("the lab's message to its peers would be {} bytes long, but at most {} fit "
                                            "(gateway.max_message_bytes); use at most {} robots",
                                            bytes_with(arena.robots.size()), limit, fit));
}

}  // namespace arkmesh::app
