#include "app/lab_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace arkmesh::app {

std::vector<hal::Config> read_labs(const LabFiles& labs, std::int64_t seed) {
  // "shark:key=value" is for lab shark alone
  std::vector<std::string> overrides, own, names, world;
  for (const std::string& set : labs.sets) (set.find(':') < set.find('=') ? own : overrides).push_back(set);
  if (seed >= 0) overrides.push_back(fmt::format("run.seed={}", seed));
  for (const std::string& file : labs.files) {
    const auto root = hal::Config::from_file(file, overrides).root();
    const std::string name = root.section("lab").get("name", std::string(), {.required = true});
    if (std::ranges::find(names, name) != names.end())
      throw hal::ConfigError(fmt::format("{}: lab '{}' is given twice; each file must name another lab", file, name));
    names.push_back(name);
    for (std::string& each : root.section("shared").get("labs", std::vector<std::string>()))
      if (std::ranges::find(world, each) == world.end()) world.push_back(std::move(each));
  }
  for (const std::string& set : own)
    if (const std::string lab = set.substr(0, set.find(':')); std::ranges::find(names, lab) == names.end())
      throw hal::ConfigError(
          fmt::format("--set {}: there is no lab {}; the labs are {}", set, lab, fmt::join(names, ", ")));
  if (std::none_of(overrides.begin(), overrides.end(),
                   [](const std::string& s) { return s.starts_with("shared.labs="); })) {
    overrides.push_back(fmt::format("shared.labs=[\"{}\"]", fmt::join(names, "\",\"")));
    std::erase_if(world, [&](const std::string& each) { return std::ranges::find(names, each) != names.end(); });
    if (!world.empty()) overrides.push_back(fmt::format("shared.absent=[\"{}\"]", fmt::join(world, "\",\"")));
  }
  std::vector<hal::Config> configs;
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::vector<std::string> all = overrides;
    for (const std::string& set : own)
      if (set.starts_with(names[i] + ":")) all.push_back(set);
    configs.push_back(hal::Config::from_file(labs.files[i], all));
  }
  return configs;
}

}  // namespace arkmesh::app
