#include "gateway/federation/watcher.hpp"

#include <fmt/format.h>

#include <utility>

namespace arkmesh::gateway {

Watcher::Watcher(boost::asio::io_context& io, NatsServers servers, const FederationOptions& options,
                 const std::string& name, const std::string& experiment, std::shared_ptr<TlsKeys> keys, Heard heard)
    : root_(subject_root(experiment)), keys_(name, experiment, 1, std::move(keys)), heard_(std::move(heard)) {
  NatsSettings nats;
  nats.servers = std::move(servers);
  nats.name = fmt::format("arkmesh watcher {}", name);
  nats.server_ca = options.server_ca;
  nats.credentials = options.credentials;
  nats.subjects = {fmt::format("{}.*.{}", root_, to_watchers)};
  connection_ = std::make_unique<NatsConnection>(
      io, std::move(nats),
      NatsConnection::Events{
          .arrived = [this](const std::vector<NatsConnection::Message>& messages) { take(messages); }});
}

hal::Counters Watcher::counters() const {
  hal::Counters all = keys_.counters();
  all.merge(connection_->counters());
  return all;
}

void Watcher::take(const std::vector<NatsConnection::Message>& messages) {
  for (const auto& [subject, bytes] : messages) {
    const auto packet = read_packet(bytes);
    if (!packet || !(is_watched(packet->head.kind) || packet->head.kind == PacketKind::keys)) {
      keys_.refuse("malformed");
      continue;
    }
    const std::string& from = packet->head.from;
    if (subject != fmt::format("{}.{}.{}", root_, from, to_watchers)) {
      keys_.refuse("subject");
      continue;
    }
    const PacketOrder number = order_of(packet->head);
    if (const auto newest = newest_.find(from); newest != newest_.end() && number <= newest->second) {
      keys_.refuse("repeated", from);
      continue;
    }
    // Opened before the signature is looked at: who is not trusted costs no more than that.
    const auto plain = keys_.open(*packet);
    if (!plain || !keys_.is_signed(*packet)) continue;
    newest_[from] = number;
    if (packet->head.kind == PacketKind::keys) {
      keys_.take_group_key(*packet);
      continue;
    }
    const auto watched = read_watched(*plain);
    if (!watched) {
      keys_.refuse("malformed", from);
      continue;
    }
    for (const Watched& each : *watched) heard_(from, each.channel, each.bytes);
  }
}

}  // namespace arkmesh::gateway
