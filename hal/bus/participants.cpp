#include "hal/bus/participants.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "hal/bus/channel_names.hpp"

namespace arkmesh::hal {

void Participants::fields(const Section& root) {
  root.section("lab").field("name", lab, {.help = "1 to 15 of a-z 0-9 _ -", .sample = "\"lab\"", .required = true});
  const Section shared = root.section("shared");
  shared.field("labs", labs, {.help = "the labs that take part", .default_is = "this lab"});
  shared.field(
      "owner", owner,
      {.help = "the lab that decides shared state (in DHTF: sites, types, activity)", .default_is = "the first lab"});
}

void Participants::check(const Section& root) {
  if (!is_lab_name(lab)) root.refuse("lab.name", "must be 1 to 15 of the characters a-z 0-9 _ -");
  if (labs.empty()) labs = {lab};
  std::ranges::sort(labs);
  for (const std::string& name : labs)
    if (!is_lab_name(name))
      root.refuse("shared.labs", fmt::format("'{}' is not a lab name: 1 to 15 of the characters a-z 0-9 _ -", name));
  if (std::ranges::adjacent_find(labs) != labs.end()) root.refuse("shared.labs", "names a lab twice");
  if (labs.size() > max_labs) root.refuse("shared.labs", fmt::format("names more than {} labs", max_labs));
  if (!std::ranges::binary_search(labs, lab))
    root.refuse("shared.labs", fmt::format("does not name this lab, '{}'; add it or correct lab.name", lab));
  if (owner.empty()) owner = labs.front();
  if (!std::ranges::binary_search(labs, owner))
    root.refuse("shared.owner", fmt::format("must be one of shared.labs ({})", fmt::join(labs, ", ")));
}

}  // namespace arkmesh::hal
