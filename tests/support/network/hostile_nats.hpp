// A NATS server in a test's own loop that forwards as the test says: less, more, later, or what nobody has said. It
// speaks what libnats needs of the protocol: INFO, CONNECT, PING, PONG, SUB, UNSUB, PUB, MSG.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace arkmesh::tests {

class HostileNats {
 public:
  struct Message {
    std::string subject, bytes;
    friend bool operator==(const Message&, const Message&) = default;
  };
  // Listens on 127.0.0.1; `io` outlives it.
  explicit HostileNats(boost::asio::io_context& io, std::size_t max_payload = 1 << 20);
  ~HostileNats();
  HostileNats(const HostileNats&) = delete;

  std::uint16_t port() const;
  std::string address() const { return "127.0.0.1:" + std::to_string(port()); }

  // What is forwarded at once of a message; may call the following. Unset: the message. What clients publish for
  // themselves alone (*.ECHO) is always forwarded, unless the server stalls.
  std::function<std::vector<Message>(const Message& message)> instead;
  // Called with each message as it was published, before `instead`.
  std::function<void(const Message& message)> published;
  // To all that have subscribed to its subject.
  void forward(const Message& message);
  // Ends all connections; `in_mid_message`: after the beginning of one.
  void cut(bool in_mid_message = false);
  // To all that are there a part of a message of 2 GB.
  void begin_endless(std::size_t bytes);
  // Reads nothing and says nothing, also to newcomers, until stall(false).
  void stall(bool stalls);

  // Since the beginning: publications by subject; connections; messages that were too long for max_payload.
  const std::map<std::string, std::uint64_t>& publications() const { return publications_; }
  std::uint64_t connections() const { return connected_; }
  std::uint64_t too_long() const { return too_long_; }
  // Whether these bytes stand anywhere in what was forwarded since the beginning.
  bool has_forwarded(const std::string& bytes) const;

 private:
  struct Client;
  void accept();
  void publish(const Message& message);

  boost::asio::io_context& io_;
  const std::size_t max_payload_;
  boost::asio::ip::tcp::acceptor acceptor_;
  std::vector<std::shared_ptr<Client>> clients_;  // with pending operations of the loop
  bool stalls_ = false;
  std::uint64_t connected_ = 0, too_long_ = 0;
  std::map<std::string, std::uint64_t> publications_;
  std::vector<std::string> forwarded_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // handlers hold it weakly
};

}  // namespace arkmesh::tests
