// Somebody who watches a federation and says nothing: hears what its labs let be watched, of labs that are trusted.
// Threading: everything happens on the thread that runs the loop.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gateway/federation/nats_connection.hpp"
#include "gateway/federation/options.hpp"
#include "gateway/federation/packet_keys.hpp"
#include "hal/counters.hpp"

namespace arkmesh::gateway {

class Watcher {
 public:
  // A message of a lab's channel, verified.
  using Heard = std::function<void(const std::string& lab, std::string_view channel, std::span<const std::byte> bytes)>;

  // `name`: whose keys these are. Throws hal::ConfigError when the key is of a kind that no lab can speak to.
  Watcher(boost::asio::io_context& io, NatsServers servers, const FederationOptions& options, const std::string& name,
          const std::string& experiment, std::shared_ptr<TlsKeys> keys, Heard heard);

  // What the connection to the server is, in words.
  const std::string& why() const { return connection_->why(); }
  hal::Counters counters() const;

 private:
  void take(const std::vector<NatsConnection::Message>& messages);

  const std::string root_;  // of the subjects
  PacketKeys keys_;
  Heard heard_;
  std::map<std::string, std::pair<std::uint64_t, std::uint64_t>> newest_;  // boot id and number, by lab
  std::unique_ptr<NatsConnection> connection_;
};

}  // namespace arkmesh::gateway
