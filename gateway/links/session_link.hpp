// The link to one peer over TCP, TLS or a NATS server: keeps one session open, connecting again with growing pauses or
// waiting to be connected to, and keeps what is to be sent meanwhile. Made by Connections::link().
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "gateway/address.hpp"
#include "gateway/link.hpp"
#include "gateway/links/tls_stream.hpp"
#include "gateway/outbox/ordered_inbox.hpp"
#include "gateway/outbox/outbox.hpp"
#include "gateway/session/session.hpp"

namespace arkmesh::gateway {

class Federation;
class Connections;

// Where a peer is: it listens on this machine without encryption, or anywhere over TLS, or comes to a federation.
using Target = std::variant<boost::asio::ip::tcp::endpoint, Host, Federation*>;

class SessionLink final : public Link, private Session::Owner {
 public:
  SessionLink(Connections& node, std::string peer, std::optional<Target> connect);
  ~SessionLink() override;

  const std::string& peer() const override { return peer_; }
  void start(Events events) override;
  void offer(const Rule& rule, std::string_view channel, std::span<const std::byte> bytes) override;
  LinkStats stats() const override;
  void keep_only(const Passes& passes) override;
  void stop() override;

  // For the node.
  bool started() const { return started_; }
  // Started, and expects the peer to connect.
  bool accepts() const { return started_ && !stopped_ && !connect_; }
  // An accepted connection said hello for this peer. False when it was refused.
  bool take(const std::shared_ptr<Session>& session, const Hello& hello);
  void check(Session::Time now);
  // Writes what was offered while the node was corked.
  void flush();
  // To the peer, if it is connected: what is exported from now on.
  void announce(const std::vector<ExportedChannel>& exports);

 private:
  void on_hello(Session& session, const Hello& hello) override;
  void on_up(Session& session) override;
  void on_message(Session& session, const MessageView& message) override;
  void on_heartbeat(Session& session, const Heartbeat& heartbeat, const std::optional<RoundTrip>& trip) override;
  void on_ended(Session& session, const Session::End& end) override;

  bool judge(Session& session, const Hello& hello);
  void welcome(Session& session, const Hello& hello);
  void change(bool up, std::string_view why);
  void forget_session();
  void connect();
  std::uint64_t meet(const Hello& hello);

  Connections& node_;
  const std::string peer_;
  const std::optional<Target> connect_;
  std::shared_ptr<Attempts> attempts_ = std::make_shared<Attempts>();  // shared with their streams
  bool no_path_ = false;                                               // at the last attempt
  Events events_;
  bool started_ = false, stopped_ = false, flush_wanted_ = false;
  Outbox outbox_;
  std::shared_ptr<Session> session_;  // shared with the loop's operations
  Session::Time alone_since_, next_attempt_;
  OrderedInbox inbox_;
  ClockEstimate clock_;
  std::int64_t peer_wall_ahead_us_ = 0;  // of its monotonic clock
  LinkStats stats_;                      // of the sessions that ended, and what is true now
};

}  // namespace arkmesh::gateway
