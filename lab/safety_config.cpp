#include "lab/safety_config.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace arkmesh::lab {

void SafetyConfig::fields(const hal::Section& safety) {
  safety.field(
      "commands_from", commands_from,
      {.help = "labs whose operators may pause and resume robots here, and end the run, while this lab is armed "
               "(arkmesh arm)"});
  safety.field("commands_per_s", commands_per_s,
               {.range = {0.001, 100}, .unit = "1/s", .help = "commands of each of these labs, at most"});
  safety.field(
      "pause_after_s", pause_after,
      {.range = {0, 1e6},
       .unit = "s",
       .help = "robots that keep real time pause when no new state of any peer was applied for so long, and for "
               "two periods; 0: never"});
}

void SafetyConfig::check(const hal::Section& safety, const std::string& lab,
                         const std::vector<std::string>& labs) const {
  for (const std::string& peer : commands_from) {
    if (peer == lab) safety.refuse("commands_from", "names this lab itself; its own operator may always");
    if (std::ranges::find(labs, peer) == labs.end())
      safety.refuse("commands_from", fmt::format("names '{}', which is not one of shared.labs", peer));
  }
}

}  // namespace arkmesh::lab
