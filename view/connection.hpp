// One connection of a browser: HTTP requests, one after another, and after an upgrade a WebSocket. Knows how, not what:
// that a Reception says. What a connection can hold is bounded, and one that is too slow, or sends too much, is ended
// with the reason counted.
#pragma once

#include <chrono>
#include <memory>
#include <string_view>

#include "hal/counters.hpp"
#include "hal/http/http_server.hpp"
#include "view/viewer_outbox.hpp"

namespace arkmesh::view {

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
  // Gets an answer(), or open() when it wants a WebSocket and may have it.
  virtual void asked(Connection& connection, const hal::HttpRequest& request) = 0;
  // The WebSocket is open. What is put into its outbox goes out after Connection::send().
  virtual void joined(Connection& viewer) = 0;
  // A text message of that viewer.
  virtual Heard said(Connection& viewer, std::string_view text) = 0;
  // The last call for that connection.
  virtual void left(Connection& connection) = 0;
  virtual hal::Counters& counters() = 0;
};

class Connection : public hal::HttpConnection {
 public:
  static constexpr std::size_t max_request_bytes = 8192, max_body_bytes = 256, max_message_bytes = 64 << 10;
  static constexpr int max_messages_per_s = 200;
  static constexpr int max_controls_per_s = 1000;  // pings and pongs

  // Becomes a WebSocket, as it has asked.
  virtual void open() = 0;
  // Sends what waits in the outbox, as fast as the viewer takes it.
  virtual void send() = 0;
  ViewerOutbox& outbox() { return outbox_; }
  const ViewerOutbox& outbox() const { return outbox_; }
  // Something is under way to the viewer.
  virtual bool sending() const = 0;

  bool may_control = false;  // it has shown the token, or the cookie that is given for it
  int wrong_tokens = 0;

 protected:
  using HttpConnection::HttpConnection;

 private:
  ViewerOutbox outbox_;
};

// The reception outlives it, or has told it to leave() before. `tls`: null for plain TCP.
std::shared_ptr<Connection> make_connection(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context* tls,
                                            Reception& reception);

}  // namespace arkmesh::view
