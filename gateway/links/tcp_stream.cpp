#include "gateway/links/tcp_stream.hpp"

#include <fmt/format.h>
#include <netinet/tcp.h>

#include "gateway/address.hpp"

namespace arkmesh::gateway {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

// Unsent bytes in the kernel: enough to keep it busy, little enough that newer messages can still replace older ones
// here.
constexpr int max_unsent_bytes = 128 << 10;

class TcpStream final : public AsioStream<tcp::socket> {
 public:
  TcpStream(tcp::socket socket, std::optional<tcp::endpoint> to) : AsioStream(std::move(socket)), to_(to) {}

  void open(Opened opened) override {
    if (!to_) return set_up(opened);
    connecting_ = true;
    stream_.async_connect(*to_, [this, opened = std::move(opened)](error_code error) {
      connecting_ = false;
      if (error) return opened(no_connection(to_text(*to_), error));
      set_up(opened);
    });
  }

  // No frame begins as TLS does (with a handshake or an alert), so the first bytes tell it.
  void read(boost::asio::mutable_buffer into, Done done) override {
    if (!first_) return AsioStream::read(into, std::move(done));
    first_ = false;
    AsioStream::read(into, [this, into, done = std::move(done)](error_code error, std::size_t bytes) {
      const auto* const begin = static_cast<const unsigned char*>(into.data());
      speaks_tls_ = !error && bytes >= 2 && (begin[0] == 0x16 || begin[0] == 0x15) && begin[1] == 0x03;
      done(speaks_tls_ ? boost::asio::error::no_protocol_option : error, bytes);
    });
  }
  StreamFailure explain(error_code error) const override {
    if (speaks_tls_) return {"session.closed.speaks_tls", "the other end uses TLS, and this connection is plain TCP"};
    return AsioStream::explain(error);
  }
  bool awaits_first_answer() const override { return connecting_; }
  // Saves two turns of the loop.
  std::size_t try_write(std::span<const boost::asio::const_buffer> from) override {
    error_code for_write;
    return stream_.write_some(from, for_write);
  }

 private:
  void set_up(const Opened& opened) {
    prepare(stream_);
    AsioStream::open(opened);
  }

  const std::optional<tcp::endpoint> to_;
  bool first_ = true, speaks_tls_ = false, connecting_ = false;
};

}  // namespace

void prepare(tcp::socket& socket) {
  error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &max_unsent_bytes, sizeof max_unsent_bytes);
}

StreamFailure no_connection(const std::string& there, const error_code& error) {
  namespace errc = boost::system::errc;
  const bool no_path = error == errc::timed_out || error == errc::host_unreachable ||
                       error == errc::network_unreachable || error == errc::network_down || error.value() == EHOSTDOWN;
  return {"session.failed.connect", there + ": " + error.message(), no_path};
}

std::unique_ptr<SocketStream> tcp_stream(tcp::socket socket, std::optional<tcp::endpoint> to) {
  return std::make_unique<TcpStream>(std::move(socket), to);
}

}  // namespace arkmesh::gateway
