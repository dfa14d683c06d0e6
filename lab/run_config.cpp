#include "lab/run_config.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/arenas/experiment.hpp"

namespace arkmesh::lab {
namespace {

constexpr std::string_view shared_gate_keys[] = {"gate.period_s", "gate.slack", "gate.exchange", "gate.up_period_s",
                                                 "gate.down_period_s"};

}  // namespace

void RunConfig::fields(const hal::Section& root) {
  Participants::fields(root);
  const hal::Section run = root.section("run"), shared = root.section("shared"), gate = root.section("gate");
  run.field("scenario", scenario,
            {.help = "the scenario, the same in all labs", .sample = "\"dhtf\"", .required = true});
  run.field("seed", seed, {.help = "seed of all random streams, the same in all labs"});
  run.field("duration_s", duration,
            {.range = {1e-3, 1e7}, .unit = "s", .help = "lab time of the run, in whole periods"});
  hal::Experiment{scenario}.fields(shared);  // it matters to gateways only
  shared.field("projection", projections);
  shared.field("absent", absent, {.help = "labs of shared.labs that do not take part; written by `arkmesh run`"});
  gate.field("period_s", period, {.range = {0.01, 3600}, .unit = "s", .help = "exchange period"});
  exchange.fields(gate);
  gate.field("slack", slack,
             {.range = {0, 8}, .unit = "periods", .help = "age of the peers' states that a lab applies"});
  enum class Mode { automatic, strict } mode = require_strict ? Mode::strict : Mode::automatic;
  gate.field("mode", mode,
             {.help = "\"strict\" refuses to run with an arena that cannot wait", .one_of = {"auto", "strict"}});
  require_strict = mode == Mode::strict;
  gate.field("on_peer_lost", on_peer_lost,
             {.help = "what a lab does in free mode after 5 s without a valid state of a peer; in strict mode it ends",
              .one_of = {"pause", "go_on", "end"}});
  gate.field("patience_s", patience,
             {.range = {0, 1e6},
              .unit = "s",
              .help = "longest wait for a valid state of a peer, after the peer's first sign of life"});
  root.section("robots").field(
      "absent_s", absent_after,
      {.range = {0.1, 1e6},
       .unit = "s",
       .help = "in real-time arenas, robots that reappear after this time receive parameters and messages again"});
  safety.fields(root.section("safety"));
  sensors.fields(root.section("sensors"));
}

void RunConfig::check(const hal::Section& root) {
  Participants::check(root);
  if (duration.count() % period.count() != 0)
    root.refuse("run.duration_s",
                fmt::format("must be a whole number of periods (gate.period_s = {})", period.count() * 1e-6));
  last_period = static_cast<std::uint32_t>(duration / period);

  exchange.check(root.section("gate"), period);
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
