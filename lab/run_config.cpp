#include "lab/run_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/messages.hpp"

namespace arkmesh::lab {
namespace {

// Whole microseconds of a number of seconds.
hal::LabTime whole_micro(const hal::Section& section, std::string_view key, double seconds) {
  const double micro = seconds * 1e6;
  if (std::abs(micro - std::round(micro)) > 1e-3) section.refuse(key, "must be whole microseconds");
  return hal::LabTime(std::llround(micro));
}

}  // namespace

RunConfig read_run_config(const hal::Section& root) {
  RunConfig c;
  const hal::Section lab = root.section("lab"), run = root.section("run"), shared = root.section("shared"),
                     gate = root.section("gate");

  c.lab = lab.required_text("name");
  if (!hal::is_lab_name(c.lab)) lab.refuse("name", "must be 1 to 15 of the characters a-z 0-9 _ -");

  c.scenario = run.required_text("scenario");
  c.seed = static_cast<std::uint64_t>(run.integer("seed", 1, 0));
  const double duration_s = run.number("duration_s", 1800, {1e-3, 1e7});
  c.period = whole_micro(gate, "period_s", gate.number("period_s", 2.0, {0.01, 3600}));
  const hal::LabTime duration = whole_micro(run, "duration_s", duration_s);
  if (duration.count() % c.period.count() != 0)
    run.refuse("duration_s",
               fmt::format("must be a whole number of periods (gate.period_s = {})", c.period.count() * 1e-6));
  c.last_period = static_cast<std::uint32_t>(duration / c.period);

  c.labs = shared.texts("labs", {c.lab});
  std::sort(c.labs.begin(), c.labs.end());
  for (const std::string& name : c.labs)
    if (!hal::is_lab_name(name))
      shared.refuse("labs", fmt::format("'{}' is no lab name: 1 to 15 of the characters a-z 0-9 _ -", name));
  if (std::adjacent_find(c.labs.begin(), c.labs.end()) != c.labs.end()) shared.refuse("labs", "names a lab twice");
  if (c.labs.size() > 16) shared.refuse("labs", "names more than 16 labs");
  if (!std::binary_search(c.labs.begin(), c.labs.end(), c.lab))
    shared.refuse("labs", fmt::format("does not name this lab; add \"{}\"", c.lab));
  c.owner = shared.text("owner", c.labs.front());
  if (!std::binary_search(c.labs.begin(), c.labs.end(), c.owner))
    shared.refuse("owner", fmt::format("must be one of shared.labs ({})", fmt::join(c.labs, ", ")));

  const hal::Section projections = shared.section("projection");
  for (const std::string& name : shared.names_below("projection")) {
    // A lab that does not take part may have a projection; it is checked all the same.
    const hal::Section p = projections.section(name);
    hal::Projection& projection = c.projections[name];
    projection.shift_x_m = p.number("shift_x_m", 0, {-1000, 1000});
    projection.shift_y_m = p.number("shift_y_m", 0, {-1000, 1000});
    projection.turn_rad = p.number("turn_rad", 0, {-7, 7});
    projection.scale = p.number("scale", 1, {1e-3, 1e3});
  }
  for (const std::string& name : c.labs) c.projections.try_emplace(name);

  const std::string mode = gate.choice("mode", "auto", {"auto", "strict"});
  c.require_strict = mode == "strict";
  c.slack = static_cast<std::uint32_t>(gate.integer("slack", 0, 0, 8));
  c.patience = whole_micro(gate, "patience_s", gate.number("patience_s", 600, {0, 1e6}));
  return c;
}

std::map<std::string, std::string, std::less<>> shared_settings(const hal::Config& config) {
  std::map<std::string, std::string, std::less<>> settings;
  for (const char* prefix : {"run", "shared", "scenario"})
    for (auto& [key, value] : config.in_force_below(prefix)) settings.emplace(key, value);
  for (auto& [key, value] : config.in_force_below("gate"))
    if (key == "gate.period_s" || key == "gate.slack") settings.emplace(key, value);
  return settings;
}

}  // namespace arkmesh::lab
