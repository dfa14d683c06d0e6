#include "lab/exchange/exchange_tally.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace arkmesh::lab {

void ExchangeTally::Way::add(const WorldMessage& message, std::size_t size) {
  ++messages;
  bytes += size;
  payloads += static_cast<std::uint64_t>(std::ranges::count_if(message.window, &LabState::carried));
  if (message.event) ++events;
}

nlohmann::json ExchangeTally::Way::json() const {
  return {{"messages", messages}, {"bytes", bytes}, {"payloads", payloads}, {"early_events", events}};
}

void ExchangeTally::applied(const std::vector<MergedState>& merged, std::string_view own, std::string_view owner,
                            const Exchange& exchange) {
  for (const MergedState& one : merged) {
    if (one.lab == own) continue;
    Peer& peer = peers_[one.lab];
    // By events, the clock part of a state says that what was told before is still so.
    const std::int64_t periods = exchange.by_events(one.lab == owner)
                                     ? std::min(one.payload_age_periods, one.age_periods)
                                     : one.payload_age_periods;
    // The clocks of labs in real time may differ: what is from ahead is not old.
    const auto age = static_cast<std::uint64_t>(std::max<std::int64_t>(periods, 0));
    ++peer.applied;
    peer.age_sum += age;
    peer.age_most = std::max(peer.age_most, age);
  }
}

nlohmann::json ExchangeTally::json(const Exchange& exchange, const Confirmations& events) const {
  nlohmann::json j;
  j["mode"] = name_of(exchange.mode);
  j["up_period_s"] = static_cast<double>(exchange.up.count()) / 1e6;
  j["down_period_s"] = static_cast<double>(exchange.down.count()) / 1e6;
  j["sent"] = own_.json();
  j["events"] = {{"told", events.told()},
                 {"told_early", early_},
                 {"confirmed", events.confirmed()},
                 {"unconfirmed", events.unconfirmed()},
                 {"resent", events.resent()}};
  j["received"] = j["applied"] = nlohmann::json::object();
  for (const auto& [name, peer] : peers_) {
    j["received"][name] = peer.way.json();
    const double mean = peer.applied == 0 ? 0 : static_cast<double>(peer.age_sum) / static_cast<double>(peer.applied);
    j["applied"][name] = {
        {"boundaries", peer.applied}, {"age_periods_mean", mean}, {"age_periods_most", peer.age_most}};
  }
  return j;
}

}  // namespace arkmesh::lab
