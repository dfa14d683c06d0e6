#include "lab/safety_config.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace arkmesh::lab {

void SafetyConfig::fields(const hal::Section& safety) {
  safety.field(
      "commands_from", commands_from,
      {.help = "labs whose operators may pause robots here and end the run, and resume while this lab is armed "
               "(arkmesh arm); \"*\": all of shared.labs"});
  safety.field("commands_per_s", commands_per_s,
               {.range = {0.001, 100}, .unit = "1/s", .help = "rate limit of resume commands from each of these labs"});
  safety.field("pause_after_s", pause_after,
               {.range = {0, 1e6},
                .unit = "s",
                .help = "robots in real-time arenas pause after this time, and at least two periods, without a new "
                        "state of any peer; 0: never"});
  safety.field(
      "hung_s", hung_after,
      {.range = {0, 3600},
       .unit = "s",
       .help = "the guard stops the robots of a real-robot lab that shows no sign of life for this time; 0: never"});
  safety.field("missing", missing,
               {.range = {0, 1023},
                .help = "how many robots may never have been identified when all should have stopped; with more, a "
                        "command exits with 4: a share below 1 (at least one robot), or a number; never all"});
}

std::size_t SafetyConfig::may_be_missing(std::size_t robots) const {
  const double share = missing * static_cast<double>(robots);
  const double n = missing > 0 && missing < 1 ? std::max(1.0, share) : missing;
  return robots == 0 ? 0 : std::min(static_cast<std::size_t>(n), robots - 1);
}

bool stand(std::span<const hal::NotStanding> not_seen_to, std::size_t may_be_missing) {
  const auto is_unnamed = [](const hal::NotStanding& robot) { return robot.why == hal::NotStanding::Why::not_named; };
  return std::ranges::all_of(not_seen_to, is_unnamed) && not_seen_to.size() <= may_be_missing;
}

void SafetyConfig::check(const hal::Section& safety, const std::string& lab, const std::vector<std::string>& labs) {
  if (commands_from == std::vector<std::string>{"*"}) {
    commands_from = labs;
    std::erase(commands_from, lab);
  }
  for (const std::string& peer : commands_from) {
    if (peer == lab) safety.refuse("commands_from", "names this lab itself; its own operator is always allowed");
    if (std::ranges::find(labs, peer) == labs.end())
      safety.refuse("commands_from", fmt::format("names '{}', which is not in shared.labs", peer));
  }
}

}  // namespace arkmesh::lab
