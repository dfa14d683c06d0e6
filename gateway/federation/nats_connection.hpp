// A connection to one of several NATS servers, kept open: the next of the list is tried when one is lost or silent. By
// libnats, which this file hides.
// Threading: everything happens on the thread that runs the loop. libnats connects only by waiting, so it does that in
// a thread of its own that nobody waits for; its timer, collector and callback threads do nothing that we asked for.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gateway/federation/nats_address.hpp"
#include "hal/counters.hpp"

namespace arkmesh::gateway {

struct NatsSettings {
  NatsServers servers;
  std::string name;                   // of this client, for the server's monitoring
  std::filesystem::path server_ca;    // of the servers' certificates; empty: the system's
  std::filesystem::path credentials;  // a .creds file; empty: none
  std::vector<std::string> subjects;  // to hear
  // For nobody but this client to publish on: shows that the server still forwards. Empty: it publishes nothing.
  std::string own_subject;
  std::chrono::milliseconds first_retry{100}, longest_retry{5000};
};

class NatsConnection {
 public:
  struct Message {
    std::string subject;
    std::vector<std::byte> bytes;
  };
  struct Events {
    std::function<void()> up;
    std::function<void()> down;  // why() says why
    // All that came at once.
    std::function<void(std::vector<Message> messages)> arrived;
    std::function<void()> writable;  // what waited for the server is written
  };
  NatsConnection(boost::asio::io_context& io, NatsSettings settings, Events events);
  ~NatsConnection();
  NatsConnection(const NatsConnection&) = delete;

  bool up() const;
  // In words, what the state of the connection is, or why there is none.
  const std::string& why() const;
  // What the server takes in one message.
  std::size_t max_payload() const;
  // Bytes that wait for the server.
  std::size_t waiting_bytes() const;
  // False when there is no connection, or the message is too long. Goes at once.
  bool publish(const std::string& subject, std::span<const std::byte> bytes);

  // server.connected, server.failed.connect, server.closed.lost, server.closed.silent, server.closed.endless,
  // server.refused.payload_limit, server.error
  const hal::Counters& counters() const;

 private:
  struct State;
  std::shared_ptr<State> state_;  // with handlers of the loop
};

}  // namespace arkmesh::gateway
