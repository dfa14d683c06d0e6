// `arkmesh status`: how a lab and its links to others are, from what they say on the lab's bus.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "cli/bus_options.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "hal/bus.hpp"
#include "hal/label.hpp"
#include "hal/loss.hpp"
#include "hal/messages.hpp"
#include "lab/message_check.hpp"

namespace arkmesh::cli {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto speaks_within = 2500ms;  // labs and gateways speak once a second
constexpr auto refresh_every = 1s;
constexpr std::size_t longest_text = 200;

// A message and the one before it, of which rates are made.
template <class Message>
struct Heard {
  std::optional<Message> newest, before;
  Clock::time_point newest_at, before_at;

  void hear(Message message) {
    before = std::exchange(newest, std::move(message));
    before_at = std::exchange(newest_at, Clock::now());
  }
  double age_s() const { return std::chrono::duration<double>(Clock::now() - newest_at).count(); }
  double between_s() const { return std::chrono::duration<double>(newest_at - before_at).count(); }
};

std::int64_t value_of(const std::vector<counter_t>& counters, std::string_view name) {
  for (const counter_t& counter : counters)
    if (counter.name == name) return counter.value;
  return 0;
}

nlohmann::json to_json(const std::vector<counter_t>& counters) {
  nlohmann::json out = nlohmann::json::object();
  for (const counter_t& counter : counters) out[hal::printable(counter.name, longest_text)] = counter.value;
  return out;
}

class Listener {
 public:
  explicit Listener(const hal::BusConfig& config)
      : url_(config.url),
        bus_(config.url, config.hear),
        statuses_(bus_.subscribe(hal::channel::status,
                                 [this](std::string_view, auto bytes) {
                                   lab_status_t status;
                                   if (lab::check_status(bytes).empty() && hal::decode(bytes, status))
                                     lab_.hear(std::move(status));
                                 })),
        links_(bus_.subscribe(hal::channel::peers, [this](std::string_view, auto bytes) {
          peers_t peers;
          if (lab::check_peers(bytes).empty() && hal::decode(bytes, peers)) gateway_.hear(std::move(peers));
        })) {}

  void listen(Clock::duration time, OperatorStop& stop) {
    for (const auto until = Clock::now() + time; !stop.stopped() && Clock::now() < until;) bus_.drain(20ms);
  }
  // Until both have spoken, the gateway twice, or had the time to.
  void listen_first(OperatorStop& stop) {
    for (const auto until = Clock::now() + speaks_within;
         !stop.stopped() && Clock::now() < until && !(lab_.newest && gateway_.before);)
      bus_.drain(20ms);
    if (!stop.stopped() && !lab_.newest && !gateway_.newest)
      throw std::runtime_error(fmt::format(
          "neither a lab nor a gateway speaks on {}; are they running, and is this their file? (arkmesh status --help)",
          url_));
  }

  nlohmann::json json() const {
    nlohmann::json out{{"bus", url_}, {"lab", nullptr}, {"gateway", nullptr}};
    if (lab_.newest) out["lab"] = lab_json();
    if (gateway_.newest) out["gateway"] = gateway_json();
    return out;
  }

 private:
  nlohmann::json lab_json() const {
    const lab_status_t& lab = *lab_.newest;
    return {{"name", hal::printable(lab.lab, longest_text)},
            {"state", hal::printable(lab.state, longest_text)},
            {"period", lab.period},
            {"last_period", lab.last_period},
            {"lab_time_s", static_cast<double>(lab.stamp_us) * 1e-6},
            {"speed", lab.speed},
            {"age_s", lab_.age_s()},
            {"counters", to_json(lab.counters)}};
  }

  nlohmann::json gateway_json() const {
    nlohmann::json peers = nlohmann::json::object();
    for (const peer_t& peer : gateway_.newest->peers) peers[hal::printable(peer.lab, longest_text)] = peer_json(peer);
    return {{"of", hal::printable(gateway_.newest->lab, longest_text)},
            {"age_s", gateway_.age_s()},
            {"peers", peers},
            {"counters", to_json(gateway_.newest->counters)}};
  }

  nlohmann::json peer_json(const peer_t& peer) const {
    nlohmann::json channels = nlohmann::json::object();
    std::optional<double> newest_s;
    for (const channel_age_t& channel : peer.channels) {
      if (channel.age_us < 0) continue;
      const double age_s = static_cast<double>(channel.age_us) * 1e-6 + gateway_.age_s();
      if (!newest_s || age_s < *newest_s) newest_s = age_s;
      channels[hal::printable(channel.channel, longest_text)] = {
          {"age_s", age_s}, {"messages", channel.messages}, {"bytes", channel.bytes}};
    }
    nlohmann::json out{{"up", peer.up != 0},
                       {"why", hal::printable(peer.why, longest_text)},
                       {"version", hal::printable(peer.version, longest_text)},
                       {"round_trip_s", nullptr},
                       {"clock", nullptr},
                       {"newest_age_s", newest_s ? nlohmann::json(*newest_s) : nlohmann::json()},
                       {"waiting_messages", value_of(peer.counters, "outbox.waiting.messages")},
                       {"waiting_bytes", value_of(peer.counters, "outbox.waiting.bytes")},
                       {"channels", channels},
                       {"counters", to_json(peer.counters)}};
    if (peer.round_trip_us >= 0) {
      out["round_trip_s"] = static_cast<double>(peer.round_trip_us) * 1e-6;
      out["clock"] = {{"offset_s", static_cast<double>(peer.clock_offset_us) * 1e-6},
                      {"uncertainty_s", static_cast<double>(peer.clock_uncertainty_us) * 1e-6}};
    }
    for (const char* what : {"sent.messages", "sent.bytes", "received.messages", "received.bytes"})
      out["per_s"][what] = rate(peer, what);
    return out;
  }

  // Between the newest two messages of the gateway; null when there is one, or when it was started anew.
  nlohmann::json rate(const peer_t& peer, std::string_view counter) const {
    if (!gateway_.before || gateway_.before->boot_id != gateway_.newest->boot_id || gateway_.between_s() <= 0)
      return {};
    for (const peer_t& former : gateway_.before->peers)
      if (former.lab == peer.lab)
        return static_cast<double>(value_of(peer.counters, counter) - value_of(former.counters, counter)) /
               gateway_.between_s();
    return {};
  }

  std::string url_;
  Heard<lab_status_t> lab_;
  Heard<peers_t> gateway_;
  hal::Bus bus_;
  std::unique_ptr<hal::Bus::Subscription> statuses_, links_;
};

// ---------------------------------------------------------------- as text

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

std::string in_words(const nlohmann::json& status) {
  std::string text, losses;
  if (const nlohmann::json& lab = status["lab"]; lab.is_null()) {
    text += "no lab speaks; start it with: arkmesh lab FILE\n";
  } else {
    const std::string name = lab["name"];
    text += fmt::format("lab {}: {}, period {} of {}, {:.1f}x real time, said {:.1f} s ago\n", name,
                        lab["state"].get<std::string>(), lab["period"].get<int>(), lab["last_period"].get<int>(),
                        lab["speed"].get<double>(), lab["age_s"].get<double>());
    add_losses(losses, name, lab["counters"]);
  }
  if (const nlohmann::json& gateway = status["gateway"]; gateway.is_null()) {
    text += "no gateway speaks; start it with: arkmesh gateway FILE\n";
  } else {
    text += fmt::format("gateway of {}, said {:.1f} s ago\n", gateway["of"].get<std::string>(),
                        gateway["age_s"].get<double>());
    constexpr const char* row = "  {:<10}{:<6}{:>11}{:>22}{:>10}{:>12}{:>10}{:>9}  {}\n";
    text += fmt::format(row, "peer", "link", "round trip", "its clock", "newest", "received/s", "sent/s", "waiting",
                        "last change");
    for (const auto& [name, peer] : gateway["peers"].items()) {
      text += fmt::format(row, name, peer["up"].get<bool>() ? "up" : "down", milliseconds(peer["round_trip_s"]),
                          clock_of(peer["clock"]), number(peer["newest_age_s"], " s"),
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
  Listener listener(options.bus());
  listener.listen_first(stop);
  if (stop.stopped()) return;
  if (json) return fmt::print("{}\n", listener.json().dump(2));
  if (isatty(STDOUT_FILENO) != 1) return fmt::print("{}", in_words(listener.json()));
  while (!stop.stopped()) {
    fmt::print("\033[H\033[2J{}\nCtrl-C ends this\n", in_words(listener.json()));
    std::fflush(stdout);
    listener.listen(refresh_every, stop);
  }
}

}  // namespace

void add_status_command(CLI::App& app) {
  CLI::App* command = add_command(app, "status");
  const auto options = std::make_shared<BusOptions>();
  const auto json = std::make_shared<bool>(false);
  options->add_to(*command);
  command->add_flag("--json", *json, "Print it once, as JSON");
  command->footer(
      "Examples:\n  arkmesh status experiments/dhtf/shark.toml\n  arkmesh status --json | jq .gateway.peers");
  command->callback([options, json] { show_status(*options, *json); });
}

}  // namespace arkmesh::cli
