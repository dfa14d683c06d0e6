// One connection of a browser: HTTP requests, one after another, and after an upgrade a WebSocket. Knows how, not what:
// that a Reception says. What a connection can hold is bounded, and one that is too slow, or sends too much, is ended
// with the reason counted.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "hal/counters.hpp"
#include "view/outbox.hpp"

namespace arkmesh::view {

// What a browser asks for. Headers that it did not send are empty.
struct Request {
  std::string_view method, path, host, origin, cookie, body;
  std::string reached;   // the address of this machine that it came to
  bool upgrade = false;  // wants a WebSocket
};

struct Reply {
  int status = 200;
  std::string_view type = "text/plain; charset=utf-8";
  std::string body;
  std::string set_cookie;              // empty: none
  std::chrono::milliseconds after{0};  // it goes out so much later
};

// What came of a viewer's message.
struct Heard {
  bool good = true;                   // false: the viewer is to be sent away
  std::chrono::milliseconds wait{0};  // its next message is read so much later
};

class Connection;

// What a connection asks; implemented by the server.
class Reception {
 public:
  virtual ~Reception() = default;
  // To a request that wants no WebSocket.
  virtual Reply reply_to(Connection& connection, const Request& request) = 0;
  // To one that does: nothing when it may have it (status 101), else what it is told.
  virtual Reply admit(Connection& connection, const Request& request) = 0;
  // The WebSocket is open. What is put into its outbox goes out after Connection::send().
  virtual void joined(Connection& viewer, const Request& request) = 0;
  // A text message of that viewer.
  virtual Heard said(Connection& viewer, std::string_view text) = 0;
  // The last call for that connection.
  virtual void left(Connection& connection) = 0;
  virtual hal::Counters& counters() = 0;
};

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  static constexpr std::size_t max_request_bytes = 8192, max_body_bytes = 256, max_message_bytes = 64 << 10;
  static constexpr int max_messages_per_s = 200;
  static constexpr int max_controls_per_s = 1000;  // pings and pongs

  virtual ~Connection() = default;
  virtual void start() = 0;
  // Sends what waits in the outbox, as fast as the viewer takes it.
  virtual void send() = 0;
  // Ends it at once.
  virtual void leave() = 0;
  Outbox& outbox() { return outbox_; }
  const Outbox& outbox() const { return outbox_; }
  // Something is under way to the viewer.
  virtual bool sending() const = 0;

  bool may_control = false;  // it has shown the token, or the cookie that is given for it
  boost::asio::ip::address from;
  int wrong_tokens = 0;

 private:
  Outbox outbox_;
};

// The reception outlives it, or has told it to leave() before. `tls`: null for plain TCP.
std::shared_ptr<Connection> make_connection(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context* tls,
                                            Reception& reception);

}  // namespace arkmesh::view
