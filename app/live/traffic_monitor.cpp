#include "app/live/traffic_monitor.hpp"

#include "arkmesh/peers_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/label.hpp"

namespace arkmesh::app {

TrafficMonitor::TrafficMonitor(hal::Bus& private_bus, const std::vector<std::string>& labs)
    : labs_(labs.begin(), labs.end()),
      arrived_(private_bus.subscribe("[^/]+/.+",
                                     [this](std::string_view channel, std::span<const std::byte> bytes) {
                                       const auto lab = labs_.find(channel.substr(0, channel.find('/')));
                                       if (lab == labs_.end()) return;
                                       lab::Traffic& t = by_peer_[*lab];
                                       ++t.received_messages;
                                       t.received_bytes += bytes.size();
                                     })),
      links_(private_bus.subscribe(hal::channel::peers, [this](std::string_view, std::span<const std::byte> bytes) {
        peers_t message;
        if (!hal::decode(bytes, message)) return;
        for (const peer_t& peer : message.peers) {
          if (!labs_.contains(peer.lab)) continue;
          lab::Traffic& t = by_peer_[peer.lab];
          if (hal::is_label(peer.version)) t.version = peer.version;
          t.counters.clear();
          for (const counter_t& c : peer.counters) t.counters[c.name] = static_cast<std::uint64_t>(c.value);
        }
      })) {}

}  // namespace arkmesh::app
