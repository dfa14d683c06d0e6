// One timer serves all sessions and links of the node.
#include "gateway/tcp_node.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "gateway/address.hpp"
#include "gateway/tcp_link.hpp"
#include "gateway/tcp_stream.hpp"
#include "hal/config.hpp"

namespace arkmesh::gateway {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {
constexpr std::chrono::milliseconds tick_period{50};
}

TcpNode::TcpNode(asio::io_context& io, TcpSettings settings)
    : io_(io), settings_(std::move(settings)), acceptor_(io), timer_(io), chance_(settings_.boot_id, "gateway/retry") {
  hello_.lab = settings_.lab;
  hello_.experiment = settings_.experiment;
  hello_.boot_id = settings_.boot_id;
  hello_.max_message_bytes = settings_.max_message_bytes;
  hello_.channels = settings_.exports;
  hello_frame_ = encode_frame(FrameKind::hello, encode_hello(hello_));
  if (!settings_.listen.empty()) listen();
  tick();
}

TcpNode::~TcpNode() {
  for (const auto& session : pending_) session->close("the gateway stops");
}

void TcpNode::listen() {
  const auto endpoint = loopback_endpoint(settings_.listen);
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

asio::ip::tcp::endpoint TcpNode::listening() const {
  error_code not_open;
  return acceptor_.local_endpoint(not_open);
}

// Who connects earlier waits in the kernel and hears no word, not even a refusal.
void TcpNode::accept() {
  if (accepting_ || !acceptor_.is_open()) return;
  accepting_ = true;
  acceptor_.async_accept([this, alive = std::weak_ptr(alive_)](error_code error, asio::ip::tcp::socket socket) {
    if (alive.expired()) return;
    accepting_ = false;
    if (error) return counters_.add("session.failed.accept");  // out of descriptors, say; tick() tries again
    std::erase_if(pending_, [](const auto& session) { return session->closed(); });
    // Who is honest says hello at once, so the oldest is the one to give way.
    if (pending_.size() >= settings_.max_pending) {
      counters_.add("session.closed.too_many_pending");
      notice(fmt::format("more than {} connections have not said hello; the oldest was closed", settings_.max_pending));
      pending_.front()->close("too many connections");
      pending_.erase(pending_.begin());
    }
    pending_.push_back(make_session(std::move(socket)));
    pending_.back()->begin(*this);
    accept();
  });
}

std::shared_ptr<Session> TcpNode::make_session(asio::ip::tcp::socket socket,
                                               std::optional<asio::ip::tcp::endpoint> to) const {
  return std::make_shared<Session>(tcp_stream(std::move(socket), to), settings_.times, hello_frame_);
}

std::unique_ptr<Link> TcpNode::link(std::string peer, std::string_view connect) {
  std::optional<asio::ip::tcp::endpoint> to;
  if (!connect.empty()) to = loopback_endpoint(connect);
  return std::make_unique<TcpLink>(*this, std::move(peer), to);
}

void TcpNode::tick() {
  const auto now = std::chrono::steady_clock::now();
  // Copies: what is told of an end may change the lists.
  for (const auto& session : std::vector(pending_)) session->check(now);
  std::erase_if(pending_, [](const auto& session) { return session->closed(); });
  for (TcpLink* link : std::vector(links_))
    if (std::ranges::find(links_, link) != links_.end()) link->check(now);
  if (std::ranges::any_of(links_, &TcpLink::started)) accept();
  timer_.expires_after(tick_period);
  timer_.async_wait([this, alive = std::weak_ptr(alive_)](error_code error) {
    if (!error && !alive.expired()) tick();
  });
}

void TcpNode::on_hello(Session& session, const Hello& hello) {
  const auto link =
      std::ranges::find_if(links_, [&](TcpLink* each) { return each->peer() == hello.lab && each->accepts(); });
  if (link == links_.end()) {
    counters_.add("session.refused.unknown_lab");
    const std::string why =
        hello.lab == settings_.lab
            ? fmt::format("another gateway calls itself {}, too", hello.lab)
            : fmt::format("lab {} does not expect a connection from a lab {}", settings_.lab, hello.lab);
    notice(why);
    return session.refuse(why);
  }
  const auto shared = session.shared_from_this();
  if ((*link)->take(shared, hello)) std::erase(pending_, shared);
}

void TcpNode::on_ended(Session&, const Session::End& end) {
  counters_.add(end.counter);
  notice(fmt::format("a connection from an unknown program was closed: {}", end.why));
}

void TcpNode::notice(std::string sentence) {
  if (sentence == last_notice_) return;
  last_notice_ = std::move(sentence);
  if (settings_.notice) settings_.notice(last_notice_);
}

}  // namespace arkmesh::gateway
