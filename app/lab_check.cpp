#include "app/lab_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>

#include "app/arenas.hpp"
#include "app/configured_lab.hpp"
#include "hal/event_loop.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::app {
namespace {

void refuse_real_robots(const hal::Config& config) {
  const hal::Section arena = config.root().section("arena");
  const auto use = arena.read<ArenaUse>().use;
  for (const hal::ArenaRow& row : arena_rows())
    if (row.name == use && row.robots == hal::ArenaRow::Robots::real)
      arena.refuse("use", "has real robots, which a batch cannot run; use \"ode\" or \"emulated\"");
}

// As the labs themselves would find out when they meet.
void compare(const std::string& first, const std::map<std::string, std::string, std::less<>>& own,
             const std::string& second, const std::map<std::string, std::string, std::less<>>& others) {
  for (const auto& [key, value] : own) {
    const auto other = others.find(key);
    if (other == others.end() || other->second == value) continue;
    throw hal::ConfigError(fmt::format("{} must be the same in all labs, but {} has {} and {} has {}", key, first,
                                       value, second, other->second));
  }
}

}  // namespace

std::vector<CheckedLab> check_labs(const std::vector<hal::Config>& configs) {
  hal::EventLoop loop;
  std::vector<CheckedLab> out;
  std::map<std::string, std::string, std::less<>> first;
  for (const hal::Config& config : configs) {
    refuse_real_robots(config);
    const ConfiguredLab lab(config, {}, loop);
    CheckedLab checked{.name = lab.name(),
                       .settings = config.in_force_below(""),
                       .effective = config.effective(),
                       .inputs = lab.inputs(),
                       .keep_free_bytes = lab.recorder().options().keep_free_bytes};
    if (std::ranges::any_of(out, [&](const CheckedLab& other) { return other.name == checked.name; }))
      throw hal::ConfigError(fmt::format("{}: lab '{}' is given twice; each file must name another lab",
                                         config.file().string(), checked.name));
    const auto shared = lab::shared_settings(config);
    if (out.empty())
      first = shared;
    else
      compare(out.front().name, first, checked.name, shared);
    out.push_back(std::move(checked));
  }
  return out;
}

}  // namespace arkmesh::app
