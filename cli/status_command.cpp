// `arkmesh status`: how a lab and its links to others are, from what they say on the lab's bus.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "cli/bus_options.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "hal/bus/loss.hpp"
#include "lab/operator/status_listener.hpp"

namespace arkmesh::cli {
namespace {

using namespace std::chrono_literals;

constexpr auto refresh_every = 1s;

std::string number(const nlohmann::json& value, const char* unit) {
  return value.is_null() ? "-" : fmt::format("{:.1f}{}", value.get<double>(), unit);
}

std::string milliseconds(const nlohmann::json& seconds) {
  return seconds.is_null() ? "-" : fmt::format("{:.1f} ms", 1e3 * seconds.get<double>());
}

// "+12.3 ms +- 0.2 ms": ahead of ours.
std::string clock_of(const nlohmann::json& clock) {
  if (clock.is_null()) return "-";
  return fmt::format("{:+.1f} ms +- {:.1f} ms", 1e3 * clock["offset_s"].get<double>(),
                     1e3 * clock["uncertainty_s"].get<double>());
}

void add_losses(std::string& text, const std::string& whose, const nlohmann::json& counters) {
  for (const auto& [name, n] : counters.items())
    if (hal::is_loss(name) && n != 0) text += fmt::format("  {:<10}{:<44}{}\n", whose, name, n.get<std::int64_t>());
}

// Whether a peer has what all labs must have alike as this lab has it, or its fingerprint.
std::string settings_of(const nlohmann::json& peer, const nlohmann::json& lab) {
  if (peer["settings"].is_null()) return "-";
  if (lab.is_null()) return peer["settings"];
  return peer["settings"] == lab["settings"] ? "alike" : "other";
}

std::string in_words(const nlohmann::json& status, const std::string& hung) {
  std::string text = hung.empty() ? "" : hung + '\n', losses;
  if (const nlohmann::json& lab = status["lab"]; lab.is_null()) {
    text += "no lab is heard; start it with: arkmesh lab FILE\n";
  } else {
    const std::string name = lab["name"];
    text += fmt::format("lab {}: {}, period {} of {}, {:.1f}x real time, settings {}, received {:.1f} s ago\n", name,
                        lab["state"].get<std::string>(), lab["period"].get<int>(), lab["last_period"].get<int>(),
                        lab["speed"].get<double>(), lab["settings"].get<std::string>(), lab["age_s"].get<double>());
    add_losses(losses, name, lab["counters"]);
  }
  if (const nlohmann::json& gateway = status["gateway"]; gateway.is_null()) {
    text += "no gateway is heard; start it with: arkmesh gateway FILE\n";
  } else {
    text += fmt::format("gateway of {}, received {:.1f} s ago\n", gateway["of"].get<std::string>(),
                        gateway["age_s"].get<double>());
    constexpr const char* row = "  {:<10}{:<6}{:<9}{:<10}{:<22}{:>11}{:>22}{:>10}{:>12}{:>10}{:>9}  {}\n";
    text += fmt::format(row, "peer", "link", "version", "settings", "since", "round trip", "its clock", "newest",
                        "received/s", "sent/s", "waiting", "last change");
    for (const auto& [name, peer] : gateway["peers"].items()) {
      const std::string version = peer["version"];
      text += fmt::format(
          row, name, peer["up"].get<bool>() ? "up" : "down", version.empty() ? "-" : version,
          settings_of(peer, status["lab"]), peer["since"].is_null() ? "-" : peer["since"].get<std::string>(),
          milliseconds(peer["round_trip_s"]), clock_of(peer["clock"]), number(peer["newest_age_s"], " s"),
          number(peer["per_s"]["received.messages"], ""), number(peer["per_s"]["sent.messages"], ""),
          peer["waiting_messages"].get<std::int64_t>(), peer["why"].get<std::string>());
      add_losses(losses, name, peer["counters"]);
    }
    add_losses(losses, "gateway", gateway["counters"]);
  }
  return text + (losses.empty() ? "nothing lost, replaced or refused\n" : "lost or refused\n" + losses);
}

void show_status(const BusOptions& options, bool json) {
  OperatorStop stop;
  lab::StatusListener listener(options.bus());
  try {
    listener.listen_first(stop);
  } catch (const std::runtime_error&) {
    if (const std::string hung = options.hung_words(); !hung.empty()) throw std::runtime_error(hung);
    throw;
  }
  if (stop.stopped()) return;
  if (json) return fmt::print("{}\n", listener.json().dump(2));
  if (isatty(STDOUT_FILENO) != 1) return fmt::print("{}", in_words(listener.json(), options.hung_words()));
  while (!stop.stopped()) {
    fmt::print("\033[H\033[2J{}\nPress Ctrl-C to quit\n", in_words(listener.json(), options.hung_words()));
    std::fflush(stdout);
    listener.listen(refresh_every, stop);
  }
}

}  // namespace

void add_status_command(CLI::App* command) {
  const auto options = std::make_shared<BusOptions>();
  const auto json = std::make_shared<bool>(false);
  options->add_to(*command);
  command->add_flag("--json", *json, "Print it once, as JSON");
  command->footer(
      "Examples:\n  arkmesh status experiments/dhtf/shark.toml\n  arkmesh status --json | jq .gateway.peers");
  command->callback([options, json] { show_status(*options, *json); });
}

}  // namespace arkmesh::cli
