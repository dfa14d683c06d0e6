// A gateway's place in the network: listens once for all peers, from its making; accepts from the first start of a
// link, hands each accepted connection to the link of the lab that it says hello for, and makes the links. Speaks to
// this machine without encryption, to others over TLS, and to whom it meets at a NATS server.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/federation/federation.hpp"
#include "gateway/frame/hello.hpp"
#include "gateway/link.hpp"
#include "gateway/links/session_link.hpp"
#include "gateway/session/session.hpp"
#include "hal/counters.hpp"
#include "hal/random.hpp"

namespace arkmesh::gateway {

class TlsKeys;

struct TcpSettings {
  std::string lab;                       // who we are
  std::string experiment;                // what we take part in; peers have the same
  std::uint64_t boot_id = 0;             // grows with each start of this lab's gateway; never 0
  std::vector<ExportedChannel> exports;  // what the peers are told to expect
  std::string listen;                    // "127.0.0.1:7801", "tls://0.0.0.0:7444"; empty: does not listen
  std::shared_ptr<TlsKeys> keys;         // where nothing is TLS: null
  FederationOptions federation;
  std::size_t outbox_bytes = 4 << 20;  // per peer, everything included
  std::uint32_t max_message_bytes = 1 << 20;
  std::size_t max_pending = 16;             // connections that have not said hello
  std::size_t max_pending_per_address = 8;  // over TLS, of these; plain TCP knows one address
  std::function<void(const std::string&)>
      notice;  // a sentence about connections that belong to no peer, when it changes
  FlowLimits flow;
  SessionTimes times;
  // Between attempts of a link that is down an eighth of the time since then passes, half to whole of it by chance, and
  // from the first to the second of these; where nobody answers, not even with a refusal, no more than the third, for
  // that costs nobody anything, and the path may be there again at any moment.
  std::chrono::milliseconds first_retry{50};
  std::chrono::milliseconds longest_retry{10'000};
  std::chrono::milliseconds path_retry{100};
};

class Connections final : private Session::Owner {
 public:
  // `io` outlives the node. Throws hal::ConfigError (an address that cannot be) and std::runtime_error (port in use),
  // one sentence.
  Connections(boost::asio::io_context& io, TcpSettings settings);
  ~Connections();
  Connections(const Connections&) = delete;
  Connections& operator=(const Connections&) = delete;

  // The link to one peer; `connect` empty: it is expected to connect to us. The node outlives its links.
  // Throws hal::ConfigError when `connect` is no loopback address.
  std::unique_ptr<Link> link(std::string peer, std::string_view connect = {});
  // The same over TLS to any host. Settings without keys are an error of the caller.
  std::unique_ptr<Link> tls_link(std::string peer, std::string_view connect);

  // The same over the NATS servers `connect` (nats_address.hpp). Settings without keys are an error of the caller.
  std::unique_ptr<Link> federation_link(std::string peer, std::string_view connect, bool tls);

  // For whoever watches the federations that this lab is in.
  void watch(std::string_view channel, std::span<const std::byte> bytes);

  // Calls `offering`; what links are offered by it goes out when it returns, in one write each.
  void corked(const std::function<void()>& offering);
  // What the peers are told to expect from now on: those who are connected at once.
  void set_exports(const std::vector<ExportedChannel>& exports);

  // Where it listens; port 0 when it does not.
  boost::asio::ip::tcp::endpoint listening() const;
  // What happened to connections that belong to no peer.
  hal::Counters counters() const;

 private:
  friend class SessionLink;
  void on_hello(Session& session, const Hello& hello) override;
  void on_up(Session&) override {}                           // never: pending sessions are not accepted here
  void on_message(Session&, const MessageView&) override {}  // never
  void on_heartbeat(Session&, const Heartbeat&, const std::optional<RoundTrip>&) override {}  // never
  void on_ended(Session& session, const Session::End& end) override;

  void listen();
  void accept();
  void tick();
  void notice(std::string sentence);
  void make_room(const boost::asio::ip::address& newcomer);
  // Over a connection to `to`, where lab `peer` is to be.
  std::shared_ptr<Session> make_session(const Target& to, const std::string& peer, std::shared_ptr<Attempts> attempts,
                                        std::optional<SessionTimes::Duration> answer) const;
  std::shared_ptr<Session> make_session(std::unique_ptr<SocketStream> stream,
                                        std::optional<SessionTimes::Duration> answer = {}) const;

  boost::asio::io_context& io_;
  TcpSettings settings_;
  Hello hello_;
  std::vector<std::byte> hello_frame_;
  boost::asio::ip::tcp::acceptor acceptor_;
  bool accepts_tls_ = false, accepting_ = false, corked_ = false;
  boost::asio::steady_timer timer_;
  struct Pending {
    std::shared_ptr<Session> session;  // shared with the loop's operations
    boost::asio::ip::address from;
  };
  std::vector<Pending> pending_;  // oldest first
  Session::Time keys_read_;
  std::map<std::string, std::unique_ptr<Federation>> federations_;  // by their servers; outlive the links
  std::vector<SessionLink*> links_;
  hal::RandomStream chance_;  // for the retry times
  std::string last_notice_;
  hal::Counters counters_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // handlers hold it weakly
};

}  // namespace arkmesh::gateway
