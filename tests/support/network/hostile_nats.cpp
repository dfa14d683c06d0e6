#include "tests/support/network/hostile_nats.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>
#include <sstream>
#include <string_view>
#include <utility>

namespace arkmesh::tests {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

// `*` stands for one token, `>` for all that follow.
bool matches(std::string_view pattern, std::string_view subject) {
  for (;;) {
    const auto p = pattern.substr(0, pattern.find('.')), s = subject.substr(0, subject.find('.'));
    if (p == ">") return true;
    if (p != "*" && p != s) return false;
    const bool more = p.size() < pattern.size();
    if (more != (s.size() < subject.size())) return false;
    if (!more) return true;
    pattern.remove_prefix(p.size() + 1);
    subject.remove_prefix(s.size() + 1);
  }
}

}  // namespace

struct HostileNats::Client : std::enable_shared_from_this<Client> {
  Client(HostileNats& of, tcp::socket connection) : server(&of), socket(std::move(connection)) {}

  void say(const std::string& bytes) {
    waiting += bytes;
    write();
  }
  void write() {
    if (is_writing || waiting.empty() || !server || server->stalls_) return;
    is_writing = true;
    in_write = std::exchange(waiting, {});
    asio::async_write(socket, asio::buffer(in_write), [self = shared_from_this()](error_code error, std::size_t) {
      self->is_writing = false;
      if (!error) self->write();
    });
  }
  void read() {
    if (is_reading || !server || server->stalls_) return;
    is_reading = true;
    socket.async_read_some(asio::buffer(buffer), [self = shared_from_this()](error_code error, std::size_t bytes) {
      self->is_reading = false;
      if (error) return self->close();
      self->came.append(self->buffer.data(), bytes);
      while (self->server && self->take()) continue;
      self->read();
    });
  }
  // One thing that the client says, when all of it is there.
  bool take() {
    const std::size_t end = came.find("\r\n");
    if (end == std::string::npos) return false;
    std::istringstream line(came.substr(0, end));
    std::string verb, subject, word;
    line >> verb >> subject;
    std::vector<std::string> words;
    while (line >> word) words.push_back(word);
    std::size_t taken = end + 2;
    if (verb == "PUB") {
      const std::size_t size = std::stoul(words.back());
      if (came.size() < taken + size + 2) return false;
      const Message message{subject, came.substr(taken, size)};
      taken += size + 2;
      came.erase(0, taken);
      server->publish(message);
      return true;
    }
    came.erase(0, taken);
    if (verb == "PING") say("PONG\r\n");
    if (verb == "SUB") subscriptions.emplace_back(words.back(), subject);
    if (verb == "UNSUB") std::erase_if(subscriptions, [&](const auto& each) { return each.first == subject; });
    return true;
  }
  void close() {
    error_code ignored;
    socket.close(ignored);
    subscriptions.clear();
  }

  HostileNats* server;  // null once it is gone
  tcp::socket socket;
  std::array<char, 32 << 10> buffer{};
  std::string came, waiting, in_write;
  bool is_writing = false, is_reading = false;
  std::vector<std::pair<std::string, std::string>> subscriptions;  // sid, subject
};

HostileNats::HostileNats(asio::io_context& io, std::size_t max_payload)
    : io_(io), max_payload_(max_payload), acceptor_(io, {asio::ip::address_v4::loopback(), 0}) {
  accept();
}

HostileNats::~HostileNats() {
  for (const auto& each : clients_) {
    each->server = nullptr;
    each->close();
  }
}

std::uint16_t HostileNats::port() const {
  return acceptor_.local_endpoint().port();
}

void HostileNats::accept() {
  acceptor_.async_accept([this, alive = std::weak_ptr(alive_)](error_code error, tcp::socket socket) {
    if (alive.expired() || error) return;
    ++connected_;
    socket.set_option(tcp::no_delay(true), error);
    std::erase_if(clients_, [](const auto& each) { return !each->socket.is_open(); });
    const auto& client = clients_.emplace_back(std::make_shared<Client>(*this, std::move(socket)));
    client->say("INFO {\"server_id\":\"hostile\",\"version\":\"2.9.10\",\"proto\":1,\"max_payload\":" +
                std::to_string(max_payload_) + "}\r\n");
    client->read();
    accept();
  });
}

void HostileNats::publish(const Message& message) {
  if (message.bytes.size() > max_payload_) ++too_long_;
  if (message.subject.ends_with(".ECHO")) return forward(message);
  ++publications_[message.subject];
  if (published) published(message);
  if (!instead) return forward(message);
  for (const Message& each : instead(message)) forward(each);
}

void HostileNats::forward(const Message& message) {
  bool to_anybody = false;
  for (const auto& client : clients_)
    for (const auto& [sid, subject] : client->subscriptions)
      if (matches(subject, message.subject)) {
        client->say("MSG " + message.subject + " " + sid + " " + std::to_string(message.bytes.size()) + "\r\n" +
                    message.bytes + "\r\n");
        to_anybody = true;
      }
  if (to_anybody && !message.bytes.empty()) forwarded_.push_back(message.bytes);
}

void HostileNats::cut(bool in_mid_message) {
  for (const auto& client : std::vector(clients_)) {
    error_code ignored;
    if (in_mid_message && !client->is_writing && !client->subscriptions.empty())
      asio::write(client->socket,
                  asio::buffer("MSG " + client->subscriptions[0].second + " " + client->subscriptions[0].first +
                               " 1000\r\nthe beginning"),
                  ignored);
    client->close();
  }
}

void HostileNats::begin_endless(std::size_t bytes) {
  for (const auto& client : clients_)
    if (!client->subscriptions.empty())
      client->say("MSG " + client->subscriptions[0].second + " " + client->subscriptions[0].first + " 2000000000\r\n" +
                  std::string(bytes, 'x'));
}

void HostileNats::stall(bool stalls) {
  stalls_ = stalls;
  for (const auto& client : std::vector(clients_)) {
    client->write();
    client->read();
  }
}

bool HostileNats::has_forwarded(const std::string& bytes) const {
  return std::ranges::any_of(forwarded_,
                             [&](const std::string& each) { return each.find(bytes) != std::string::npos; });
}

}  // namespace arkmesh::tests
