// One timer serves all sessions and links of the node.
#include "gateway/links/connections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <stdexcept>
#include <utility>

#include "gateway/address.hpp"
#include "gateway/links/tcp_stream.hpp"
#include "gateway/links/tls_keys.hpp"
#include "gateway/links/tls_stream.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::gateway {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {
constexpr std::chrono::milliseconds links_tick_period{50};
constexpr std::chrono::milliseconds keys_period{500};  // who is revoked is out after so long
}  // namespace

Connections::Connections(asio::io_context& io, TcpSettings settings)
    : io_(io), settings_(std::move(settings)), acceptor_(io), timer_(io), chance_(settings_.boot_id, "gateway/retry") {
  hello_.lab = settings_.lab;
  hello_.experiment = settings_.experiment;
  hello_.boot_id = settings_.boot_id;
  hello_.max_message_bytes = settings_.max_message_bytes;
  set_exports(settings_.exports);
  if (!settings_.listen.empty()) listen();
  tick();
}

Connections::~Connections() {
  for (const Pending& each : pending_) each.session->close("the gateway stops");
}

void Connections::set_exports(const std::vector<ExportedChannel>& exports) {
  hello_.channels = exports;
  hello_frame_ = encode_frame(FrameKind::hello, encode_hello(hello_));
  // Who has not got through yet comes again, and hears the new hello.
  for (const Pending& each : pending_) each.session->close("the rules of this gateway have changed");
  for (SessionLink* link : links_) link->announce(exports);
}

void Connections::listen() {
  const auto [endpoint, tls] = read_listen_address(settings_.listen);
  accepts_tls_ = tls;
  try {
    acceptor_.open(endpoint.protocol());
    acceptor_.set_option(asio::ip::tcp::acceptor::reuse_address(true));
    acceptor_.bind(endpoint);
    acceptor_.listen();
  } catch (const boost::system::system_error& error) {
    if (error.code() == asio::error::address_in_use)
      throw std::runtime_error(
          fmt::format("TCP port {} of {} is in use by another program; stop it (ss -ltnp shows it) or give "
                      "gateway.listen another port",
                      endpoint.port(), endpoint.address().to_string()));
    throw std::runtime_error(fmt::format("cannot listen on {}: {}", to_text(endpoint), error.code().message()));
  }
}

void Connections::corked(const std::function<void()>& offering) {
  struct Corked {
    bool& corked;
    ~Corked() { corked = false; }
  };
  {
    const Corked until_it_returns{corked_ = true};
    offering();
  }
  for (SessionLink* link : links_) link->flush();
}

asio::ip::tcp::endpoint Connections::listening() const {
  error_code not_open;
  return acceptor_.local_endpoint(not_open);
}

// Who connects earlier waits in the kernel and hears no word, not even a refusal.
void Connections::accept() {
  if (accepting_ || !acceptor_.is_open()) return;
  accepting_ = true;
  acceptor_.async_accept([this, alive = std::weak_ptr(alive_)](error_code error, asio::ip::tcp::socket socket) {
    if (alive.expired()) return;
    accepting_ = false;
    if (error) return counters_.add("session.failed.accept");  // out of descriptors, say; tick() tries again
    error_code gone;
    const auto from = socket.remote_endpoint(gone).address();
    make_room(from);
    auto stream = accepts_tls_ ? tls_stream(std::move(socket), settings_.keys) : tcp_stream(std::move(socket));
    pending_.push_back({make_session(std::move(stream)), from});
    pending_.back().session->begin(*this);
    accept();
  });
}

// Who is honest says hello at once, so the oldest is the one to give way: of the newcomer's own address, when that has
// its share already.
void Connections::make_room(const asio::ip::address& newcomer) {
  std::erase_if(pending_, [](const Pending& each) { return each.session->closed(); });
  const auto is_neighbour = [&](const Pending& each) { return each.from == newcomer; };
  auto oldest = pending_.end();
  if (pending_.size() >= settings_.max_pending) {
    oldest = pending_.begin();
    counters_.add("session.closed.too_many_pending");
    notice(fmt::format("more than {} connections have not sent a hello; the oldest was closed", settings_.max_pending));
  }
  if (accepts_tls_ &&
      std::cmp_greater_equal(std::ranges::count_if(pending_, is_neighbour), settings_.max_pending_per_address)) {
    oldest = std::ranges::find_if(pending_, is_neighbour);
    counters_.add("session.closed.too_many_of_address");
    notice(fmt::format("more than {} connections from {} have not sent a hello; the oldest was closed",
                       settings_.max_pending_per_address, newcomer.to_string()));
  }
  if (oldest == pending_.end()) return;
  oldest->session->close("too many connections");
  pending_.erase(oldest);
}

std::shared_ptr<Session> Connections::make_session(const Target& to, const std::string& peer,
                                                   std::shared_ptr<Attempts> attempts,
                                                   std::optional<SessionTimes::Duration> answer) const {
  if (const auto* const endpoint = std::get_if<asio::ip::tcp::endpoint>(&to))
    return make_session(tcp_stream(asio::ip::tcp::socket(io_), *endpoint), answer);
  if (auto* const* const federation = std::get_if<Federation*>(&to))
    return make_session((*federation)->stream(peer), answer);
  return make_session(
      tls_stream(asio::ip::tcp::socket(io_), settings_.keys, std::get<Host>(to), peer, std::move(attempts)), answer);
}

std::shared_ptr<Session> Connections::make_session(std::unique_ptr<SocketStream> stream,
                                                   std::optional<SessionTimes::Duration> answer) const {
  return std::make_shared<Session>(std::move(stream), settings_.times, settings_.flow, hello_frame_, answer);
}

std::unique_ptr<Link> Connections::link(std::string peer, std::string_view connect) {
  std::optional<Target> to;
  if (!connect.empty()) to = loopback_endpoint(connect);
  return std::make_unique<SessionLink>(*this, std::move(peer), std::move(to));
}

std::unique_ptr<Link> Connections::tls_link(std::string peer, std::string_view connect) {
  assert(settings_.keys && "who connects over TLS has keys");
  return std::make_unique<SessionLink>(*this, std::move(peer), read_host(connect));
}

std::unique_ptr<Link> Connections::federation_link(std::string peer, std::string_view connect, bool tls) {
  assert(settings_.keys && "members of a federation have keys");
  auto& federation = federations_[fmt::format("{} {}", tls, connect)];
  if (!federation) {
    FederationSettings settings{.options = settings_.federation};
    settings.lab = settings_.lab;
    settings.experiment = settings_.experiment;
    settings.boot_id = settings_.boot_id;
    settings.servers = read_servers(connect, tls);
    settings.keys = settings_.keys;
    settings.longest_retry = std::min(settings.longest_retry, settings_.longest_retry);
    settings.notice = [this](const std::string& sentence) { notice(sentence); };
    federation = std::make_unique<Federation>(io_, std::move(settings));
  }
  return std::make_unique<SessionLink>(*this, std::move(peer), federation.get());
}

void Connections::watch(std::string_view channel, std::span<const std::byte> bytes) {
  for (const auto& [servers, federation] : federations_) federation->watch(channel, bytes);
}

hal::Counters Connections::counters() const {
  hal::Counters all = counters_;
  for (const auto& [servers, federation] : federations_) all.merge(federation->counters());
  return all;
}

void Connections::tick() {
  const auto now = std::chrono::steady_clock::now();
  if (settings_.keys && now - keys_read_ >= keys_period) {
    settings_.keys->refresh();
    keys_read_ = now;
  }
  // Copies: what is told of an end may change the lists.
  for (const Pending& each : std::vector(pending_)) each.session->check(now);
  std::erase_if(pending_, [](const Pending& each) { return each.session->closed(); });
  for (SessionLink* link : std::vector(links_))
    if (std::ranges::find(links_, link) != links_.end()) link->check(now);
  if (std::ranges::any_of(links_, &SessionLink::started)) accept();
  timer_.expires_after(links_tick_period);
  timer_.async_wait([this, alive = std::weak_ptr(alive_)](error_code error) {
    if (!error && !alive.expired()) tick();
  });
}

void Connections::on_hello(Session& session, const Hello& hello) {
  if (const std::string proved = session.proved_name(); !proved.empty() && proved != hello.lab) {
    counters_.add("session.refused.lab_name");
    const std::string why =
        fmt::format("a connection with the certificate of lab {} calls itself lab {}", proved, hello.lab);
    notice(why);
    return session.refuse(why);
  }
  const auto link =
      std::ranges::find_if(links_, [&](SessionLink* each) { return each->peer() == hello.lab && each->accepts(); });
  if (link == links_.end()) {
    counters_.add("session.refused.unknown_lab");
    const std::string why = hello.lab == settings_.lab ? fmt::format("another gateway also calls itself {}", hello.lab)
                                                       : fmt::format("lab {} does not expect a connection from lab {}",
                                                                     settings_.lab, hello.lab);
    notice(why);
    return session.refuse(why);
  }
  const auto shared = session.shared_from_this();
  if ((*link)->take(shared, hello))
    std::erase_if(pending_, [&](const Pending& each) { return each.session == shared; });
}

void Connections::on_ended(Session&, const Session::End& end) {
  counters_.add(end.counter);
  notice(fmt::format("a connection from an unknown program was closed: {}", end.why));
}

void Connections::notice(std::string sentence) {
  if (sentence == last_notice_) return;
  last_notice_ = std::move(sentence);
  if (settings_.notice) settings_.notice(last_notice_);
}

}  // namespace arkmesh::gateway
