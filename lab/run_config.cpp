#include "lab/run_config.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/experiment.hpp"
#include "hal/messages.hpp"

namespace arkmesh::lab {
namespace {

constexpr std::string_view shared_gate_keys[] = {"gate.period_s", "gate.slack", "gate.exchange", "gate.up_period_s",
                                                 "gate.down_period_s"};

}  // namespace

void RunConfig::fields(const hal::Section& root) {
  root.section("lab").field("name", lab, {.help = "1 to 15 of a-z 0-9 _ -", .sample = "\"lab\"", .required = true});
  const hal::Section run = root.section("run"), shared = root.section("shared"), gate = root.section("gate");
  run.field("scenario", scenario, {.help = "what the labs do together", .sample = "\"dhtf\"", .required = true});
  run.field("seed", seed, {.help = "one for all labs; random streams are named lab/purpose"});
  run.field("duration_s", duration, {.range = {1e-3, 1e7}, .unit = "s", .help = "whole periods"});
  shared.field("labs", labs, {.help = "who takes part", .default_is = "this lab"});
  shared.field("owner", owner,
               {.help = "who decides what is shared (in DHTF: sites, types, activity)", .default_is = "the first lab"});
  hal::Experiment{scenario}.fields(shared);  // it matters to gateways only
  shared.field("projection", projections);
  gate.field("period_s", period, {.range = {0.01, 3600}, .unit = "s", .help = "time between two exchanges"});
  exchange.fields(gate);
  gate.field("slack", slack, {.range = {0, 8}, .unit = "periods", .help = "how old the states are that are applied"});
  enum class Mode { automatic, strict } mode = require_strict ? Mode::strict : Mode::automatic;
  gate.field("mode", mode,
             {.help = "\"strict\" refuses to run with an arena that cannot wait", .one_of = {"auto", "strict"}});
  require_strict = mode == Mode::strict;
  gate.field("on_peer_lost", on_peer_lost,
             {.help = "what a lab does in free mode when nothing of a peer has counted for 5 s; in strict mode it ends",
              .one_of = {"pause", "go_on", "end"}});
  gate.field("patience_s", patience,
             {.range = {0, 1e6},
              .unit = "s",
              .help = "how long a peer is waited for of which nothing counts, since its first sign of life"});
  safety.fields(root.section("safety"));
}

void RunConfig::check(const hal::Section& root) {
  if (!hal::is_lab_name(lab)) root.refuse("lab.name", "must be 1 to 15 of the characters a-z 0-9 _ -");
  if (duration.count() % period.count() != 0)
    root.refuse("run.duration_s",
                fmt::format("must be a whole number of periods (gate.period_s = {})", period.count() * 1e-6));
  last_period = static_cast<std::uint32_t>(duration / period);

  exchange.check(root.section("gate"), period);

  if (labs.empty()) labs = {lab};
  std::ranges::sort(labs);
  for (const std::string& name : labs)
    if (!hal::is_lab_name(name))
      root.refuse("shared.labs", fmt::format("'{}' is no lab name: 1 to 15 of the characters a-z 0-9 _ -", name));
  if (std::ranges::adjacent_find(labs) != labs.end()) root.refuse("shared.labs", "names a lab twice");
  if (labs.size() > 16) root.refuse("shared.labs", "names more than 16 labs");
  if (!std::ranges::binary_search(labs, lab))
    root.refuse("shared.labs", fmt::format("does not name this lab; add \"{}\"", lab));
  if (owner.empty()) owner = labs.front();
  if (!std::ranges::binary_search(labs, owner))
    root.refuse("shared.owner", fmt::format("must be one of shared.labs ({})", fmt::join(labs, ", ")));
  for (const std::string& name : labs) projections.try_emplace(name);
  safety.check(root.section("safety"), lab, labs);
}

std::map<std::string, std::string, std::less<>> shared_settings(const hal::Config& config) {
  std::map<std::string, std::string, std::less<>> settings;
  for (const char* table : {"run", "shared", "scenario"}) settings.merge(config.in_force_below(table));
  for (auto& [key, value] : config.in_force_below("gate"))
    if (std::ranges::find(shared_gate_keys, key) != std::end(shared_gate_keys)) settings.emplace(key, value);
  // By its name, so that labs with other periods are told of that one.
  for (const char* key : {"gate.up_period_s", "gate.down_period_s"})
    if (settings[key] == settings["gate.period_s"]) settings[key] = "gate.period_s";
  return settings;
}

}  // namespace arkmesh::lab
