#include "lab/operator/status_listener.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <stdexcept>
#include <string_view>

#include "hal/arenas/messages.hpp"
#include "hal/label.hpp"

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto speaks_within = 2500ms;  // labs and gateways speak once a second
constexpr std::size_t longest_text = 200;

std::int64_t value_of(const std::vector<counter_t>& counters, std::string_view name) {
  const auto found = std::ranges::find(counters, name, &counter_t::name);
  return found == counters.end() ? 0 : found->value;
}

nlohmann::json to_json(const std::vector<counter_t>& counters) {
  nlohmann::json out = nlohmann::json::object();
  for (const counter_t& counter : counters) out[hal::printable(counter.name, longest_text)] = counter.value;
  return out;
}

}  // namespace

StatusListener::StatusListener(const hal::BusConfig& config)
    : url_(config.url),
      bus_(config.url, config.hear),
      statuses_(bus_.subscribe(hal::channel::status,
                               [this](std::string_view, auto bytes) {
                                 lab_status_t status;
                                 if (hal::decode(bytes, status)) lab_.hear(std::move(status));
                               })),
      links_(bus_.subscribe(hal::channel::peers,
                            [this](std::string_view, auto bytes) {
                              peers_t peers;
                              if (hal::decode(bytes, peers)) gateway_.hear(std::move(peers));
                            })),
      peers_(
          bus_.subscribe(fmt::format("[^/]+/{}", hal::channel::status), [this](std::string_view channel, auto bytes) {
            lab_status_t status;
            if (!gateway_.newest || !hal::decode(bytes, status) ||
                channel != fmt::format("{}/{}", status.lab, hal::channel::status))
              return;
            // Whoever else claims to be a lab is not kept.
            if (std::ranges::count(gateway_.newest->peers, status.lab, &peer_t::lab) > 0)
              settings_[status.lab] = hal::printable(status.settings, longest_text);
          })) {}

void StatusListener::listen(std::chrono::milliseconds time, hal::StopRequest& stop) {
  for (const auto until = Clock::now() + time; !stop.stopped() && Clock::now() < until;) bus_.drain(20ms);
}
void StatusListener::listen_first(hal::StopRequest& stop) {
  for (const auto until = Clock::now() + speaks_within;
       !stop.stopped() && Clock::now() < until && !(lab_.newest && gateway_.before);)
    bus_.drain(20ms);
  if (!stop.stopped() && !lab_.newest && !gateway_.newest)
    throw std::runtime_error(fmt::format(
        "neither a lab nor a gateway is heard on {}; are they running, and is this their file? (arkmesh status --help)",
        url_));
}

nlohmann::json StatusListener::json() const {
  nlohmann::json out{{"bus", url_}, {"lab", nullptr}, {"gateway", nullptr}};
  if (lab_.newest) out["lab"] = lab_json();
  if (gateway_.newest) out["gateway"] = gateway_json();
  return out;
}

nlohmann::json StatusListener::lab_json() const {
  const lab_status_t& lab = *lab_.newest;
  return {{"name", hal::printable(lab.lab, longest_text)},
          {"state", hal::printable(lab.state, longest_text)},
          {"period", lab.period},
          {"last_period", lab.last_period},
          {"lab_time_s", static_cast<double>(lab.stamp_us) * 1e-6},
          {"speed", lab.speed},
          {"settings", hal::printable(lab.settings, longest_text)},
          {"age_s", lab_.age_s()},
          {"counters", to_json(lab.counters)}};
}

nlohmann::json StatusListener::gateway_json() const {
  nlohmann::json peers = nlohmann::json::object();
  for (const peer_t& peer : gateway_.newest->peers) peers[hal::printable(peer.lab, longest_text)] = peer_json(peer);
  return {{"of", hal::printable(gateway_.newest->lab, longest_text)},
          {"age_s", gateway_.age_s()},
          {"peers", peers},
          {"counters", to_json(gateway_.newest->counters)}};
}

nlohmann::json StatusListener::peer_json(const peer_t& peer) const {
  nlohmann::json channels = nlohmann::json::object();
  std::optional<double> newest_s;
  for (const channel_age_t& channel : peer.channels) {
    if (channel.age_us < 0) continue;
    const double age_s = static_cast<double>(channel.age_us) * 1e-6 + gateway_.age_s();
    if (!newest_s || age_s < *newest_s) newest_s = age_s;
    channels[hal::printable(channel.channel, longest_text)] = {
        {"age_s", age_s}, {"messages", channel.messages}, {"bytes", channel.bytes}};
  }
  const auto settings = settings_.find(peer.lab);
  nlohmann::json out{{"up", peer.up != 0},
                     {"why", hal::printable(peer.why, longest_text)},
                     {"version", hal::printable(peer.version, longest_text)},
                     {"since", nullptr},
                     {"settings", settings == settings_.end() ? nlohmann::json() : nlohmann::json(settings->second)},
                     {"round_trip_s", nullptr},
                     {"clock", nullptr},
                     {"newest_age_s", newest_s ? nlohmann::json(*newest_s) : nlohmann::json()},
                     {"waiting_messages", value_of(peer.counters, "outbox.waiting.messages")},
                     {"waiting_bytes", value_of(peer.counters, "outbox.waiting.bytes")},
                     {"channels", channels},
                     {"counters", to_json(peer.counters)}};
  // a boot id tells when the gateway was started, by its own clock
  if (peer.boot_id > 0) out["since"] = fmt::format("{:%FT%TZ}", fmt::gmtime(std::time_t{peer.boot_id / 1'000'000}));
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
nlohmann::json StatusListener::rate(const peer_t& peer, std::string_view counter) const {
  if (!gateway_.before || gateway_.before->boot_id != gateway_.newest->boot_id || gateway_.between_s() <= 0) return {};
  for (const peer_t& former : gateway_.before->peers)
    if (former.lab == peer.lab)
      return static_cast<double>(value_of(peer.counters, counter) - value_of(former.counters, counter)) /
             gateway_.between_s();
  return {};
}

}  // namespace arkmesh::lab
