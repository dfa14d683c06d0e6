// A gateway's place in a federation: labs that meet at a NATS server instead of at each other's doors. Gives sessions
// their streams to peers; what they write at the same time to several peers goes out once, signed.
// Threading: everything happens on the thread that runs the loop.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/federation/nats_connection.hpp"
#include "gateway/federation/options.hpp"
#include "gateway/federation/packet_keys.hpp"
#include "gateway/federation/relay.hpp"
#include "gateway/links/socket_stream.hpp"
#include "gateway/links/tls_keys.hpp"
#include "hal/counters.hpp"

namespace arkmesh::gateway {

struct FederationSettings {
  FederationOptions options;
  std::string lab, experiment;
  std::uint64_t boot_id = 0;  // grows with each start of this lab's gateway; never 0
  NatsServers servers;
  std::shared_ptr<TlsKeys> keys;
  std::chrono::milliseconds longest_retry = NatsSettings{}.longest_retry;  // of the connection to a server
  std::function<void(const std::string&)> notice;  // a sentence about strangers, when it changes
};

class Federation {
 public:
  // Throws hal::ConfigError when the lab's key is of a kind that cannot sign packets.
  Federation(boost::asio::io_context& io, FederationSettings settings);
  ~Federation();
  Federation(const Federation&) = delete;

  // A stream to that lab, at most one at a time; it is open once the lab has opened one to us. The federation outlives
  // it.
  std::unique_ptr<SocketStream> stream(const std::string& peer);

  // The newest message of a channel, for whoever watches: sampled, never acknowledged.
  void watch(std::string_view channel, std::span<const std::byte> bytes);

  // Of the server's connection, and federation.refused.*, of which those of a lab that is known end with its name.
  hal::Counters counters() const;

 private:
  class Stream;
  friend class Stream;
  using Time = Relay::Time;

  void came_up();
  void went_down();
  void take(std::vector<NatsConnection::Message> messages);
  void take(const PacketView& packet);
  void take(const std::string& from, PacketOrder at, const PacketBody& body);
  void deliver(const std::string& peer, StreamId of);
  bool is_for_us(const std::string& from, const PacketBody& body) const;
  ChunkPointer chunk(std::span<const std::byte> bytes, bool is_message);

  void flush_soon();
  void flush();
  void send_fresh_messages(Time now);
  void send_to(Stream& stream, Time now, std::vector<Greeting> greetings = {}, bool ends = false);
  Relay::Duration ask_period() const;
  Relay::Duration ack_time() const;
  void ask();
  bool are_keys_due(Time now) const;
  void send_keys();
  void send_watched();
  void publish_to_all(const std::vector<std::byte>& packet);
  void publish_sealed(const std::string& to, const PacketBody& body);
  std::size_t room() const;
  bool is_congested() const;
  void tick();

  boost::asio::io_context& io_;
  FederationSettings settings_;
  const std::string root_;  // of the subjects
  PacketKeys keys_;
  std::unique_ptr<NatsConnection> connection_;
  std::map<std::string, Stream*> streams_;  // by peer
  std::vector<ChunkPointer> fresh_;         // written since the last flush
  bool flush_posted_ = false, keys_wanted_ = false;
  Time asked_{}, keys_sent_{}, watched_sent_{};
  int watched_rounds_ = 0;
  struct Newest {
    std::vector<std::byte> bytes;
    bool is_fresh = false;
  };
  std::map<std::string, Newest, std::less<>> watched_;  // by channel
  boost::asio::steady_timer timer_;
  hal::Counters counters_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // handlers hold it weakly
};

}  // namespace arkmesh::gateway
