#include "gateway/tcp_stream.hpp"

#include <fmt/format.h>
#include <netinet/tcp.h>

#include "gateway/address.hpp"

namespace arkmesh::gateway {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

// Unsent bytes in the kernel: enough to keep it busy, little enough that newer messages can still replace older ones
// here.
constexpr int max_unsent_bytes = 64 << 10;

class TcpStream final : public AsioStream<tcp::socket> {
 public:
  TcpStream(tcp::socket socket, std::optional<tcp::endpoint> to) : AsioStream(std::move(socket)), to_(to) {}

  void open(Opened opened) override {
    if (!to_) return set_up(opened);
    stream_.async_connect(*to_, [this, opened = std::move(opened)](error_code error) {
      if (error) return opened(fmt::format("{}: {}", to_text(*to_), error.message()));
      set_up(opened);
    });
  }

 private:
  void set_up(const Opened& opened) {
    error_code ignored;
    stream_.set_option(tcp::no_delay(true), ignored);
    setsockopt(stream_.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &max_unsent_bytes, sizeof max_unsent_bytes);
    AsioStream::open(opened);
  }

  const std::optional<tcp::endpoint> to_;
};

}  // namespace

std::unique_ptr<ByteStream> tcp_stream(tcp::socket socket, std::optional<tcp::endpoint> to) {
  return std::make_unique<TcpStream>(std::move(socket), to);
}

}  // namespace arkmesh::gateway
