#include "gateway/links/tls_stream.hpp"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <algorithm>
#include <boost/asio/connect.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "gateway/links/host_lookup.hpp"
#include "gateway/links/tcp_stream.hpp"

namespace arkmesh::gateway {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using TlsSocket = asio::ssl::stream<tcp::socket>;

// The longest plain text of a TLS record.
constexpr std::size_t max_record_bytes = 16 << 10;

class TlsStream final : public AsioStream<TlsSocket> {
 public:
  TlsStream(tcp::socket socket, std::shared_ptr<TlsKeys> keys, std::optional<Host> to, std::string expected,
            std::shared_ptr<Attempts> attempts)
      : AsioStream(TlsSocket(std::move(socket), keys->context())),
        keys_(std::move(keys)),
        to_(std::move(to)),
        expected_(std::move(expected)),
        attempts_(std::move(attempts)) {}

  void open(Opened opened) override {
    if (!to_) return shake_hands(std::move(opened));
    if (attempts_->number % 2 == 1 && !attempts_->addresses.empty()) return connect(std::move(opened));
    lookup_.emplace(executor(), *to_, [this, opened = std::move(opened)](const std::string& error, auto addresses) {
      if (closed_ || !error.empty()) return opened({"session.failed.connect", there() + error, true});
      attempts_->addresses = std::move(addresses);
      connect(opened);
    });
  }

  // One record for as many whole buffers as fit, so that a small frame is never two; a long one is what it is.
  void write(std::span<const asio::const_buffer> from, Done done) override {
    std::size_t bytes = 0, buffers = 0;
    while (buffers < from.size() && bytes + from[buffers].size() <= max_record_bytes) bytes += from[buffers++].size();
    if (buffers <= 1) return stream_.async_write_some(asio::const_buffer(from.front()), std::move(done));
    record_.resize(bytes);
    asio::buffer_copy(asio::buffer(record_), from.first(buffers));
    stream_.async_write_some(asio::const_buffer(asio::buffer(record_)), std::move(done));
  }

  void close() override {
    closed_ = true;
    if (lookup_) lookup_->cancel();
    AsioStream::close();
  }

  std::string peer_name() const override { return peer_; }
  StreamFailure objection() const override {
    const auto verdict = keys_->judge(pin_);
    if (verdict.standing == TlsKeys::Verdict::revoked)
      return {"session.closed.certificate_revoked", fmt::format("the certificate of lab {} was revoked here", peer_)};
    if (verdict.standing == TlsKeys::Verdict::unknown)
      return {"session.closed.certificate_untrusted",
              fmt::format("the certificate of lab {} is no longer trusted here", peer_)};
    return {};
  }
  // The end of TCP is enough: each frame says how long it is, so nothing can be cut off unseen.
  StreamFailure explain(error_code error) const override {
    if (error == asio::ssl::error::stream_truncated) return AsioStream::explain(asio::error::eof);
    return told_by_peer(error).value_or(AsioStream::explain(error));
  }
  bool awaits_first_answer() const override { return connecting_; }
  std::string too_slow() const override { return shaking_ ? "session.failed.slow_handshake" : AsioStream::too_slow(); }

 private:
  std::string there() const { return to_ ? to_text(*to_) + ": " : std::string(); }

  void connect(Opened opened) {
    addresses_ = attempts_->addresses;
    const auto first = addresses_.begin() + static_cast<std::ptrdiff_t>(attempts_->number / 2 % addresses_.size());
    std::rotate(addresses_.begin(), first, addresses_.end());
    connecting_ = true;
    asio::async_connect(stream_.next_layer(), addresses_,
                        [this, opened = std::move(opened)](error_code failed, const tcp::endpoint&) {
                          connecting_ = false;
                          if (closed_ || failed) return opened(no_connection(to_text(*to_), failed));
                          shake_hands(opened);
                        });
  }

  void shake_hands(const Opened& opened) {
    shaking_ = true;
    prepare(stream_.next_layer());
    TlsKeys::keep_shown(stream_.native_handle(), shown_);
    stream_.async_handshake(to_ ? TlsSocket::client : TlsSocket::server, [this, opened](error_code error) {
      StreamFailure failure = error ? why_no_handshake(error) : take_name();
      if (!failure.counter.empty()) {
        failure.why = there() + failure.why;
        return opened(failure);
      }
      AsioStream::open(opened);
    });
  }

  // Of the certificate that was shown. check_peer() has let it pass, but keys may have been taken back, or be replaced
  // at this moment, since then: who is not trusted now has no name, and gets no word.
  StreamFailure take_name() {
    const X509Pointer shown = std::move(shown_);
    const auto pin = shown ? pin_of(*shown) : std::nullopt;
    if (!pin) return {"session.refused.certificate_unknown", "the other end showed no certificate"};
    pin_ = *pin;
    const TlsKeys::Verdict verdict = keys_->judge(pin_);
    peer_ = verdict.lab;
    if (verdict.standing != TlsKeys::Verdict::trusted)
      return {verdict.standing == TlsKeys::Verdict::revoked ? "session.refused.certificate_revoked"
                                                            : "session.refused.certificate_unknown",
              "its certificate ceased to be trusted here during the handshake"};
    if (!expected_.empty() && peer_ != expected_)
      return {"session.refused.certificate_of_other_lab",
              fmt::format("the other end has the certificate of lab {}, not of lab {}", peer_, expected_)};
    keys_->saw(pin_, end_of(*shown));
    return {};
  }

  StreamFailure why_no_handshake(error_code error) {
    const long result = SSL_get_verify_result(stream_.native_handle());
    if (result == X509_V_ERR_CERT_REVOKED)
      return {"session.refused.certificate_revoked", "its certificate was revoked here" + describe_shown()};
    if (result != X509_V_OK)
      return {"session.refused.certificate_unknown",
              "its certificate is not trusted here; trust it with arkmesh keys trust FILE.crt" + describe_shown()};
    if (auto told = told_by_peer(error)) return *told;
    if (error.category() != asio::error::get_ssl_category())
      return {"session.failed.handshake", "the connection ended during the TLS handshake (" + error.message() + ")"};
    switch (ERR_GET_REASON(static_cast<unsigned long>(error.value()))) {
      case SSL_R_WRONG_VERSION_NUMBER:
      case SSL_R_HTTP_REQUEST:
      case SSL_R_HTTPS_PROXY_REQUEST:
        say_tls();
        return {"session.refused.plain_tcp", "the other end does not use TLS, and this connection is tls://"};
      case SSL_R_PEER_DID_NOT_RETURN_A_CERTIFICATE:
        return {"session.refused.certificate_unknown", "the other end showed no certificate"};
      default:
        return {"session.failed.handshake", "the TLS handshake failed (" + error.message() + ")"};
    }
  }

  // OpenSSL leaves who speaks no TLS without a word. The alert for a wrong version is what a gateway knows TLS by.
  void say_tls() {
    constexpr unsigned char alert[] = {0x15, 0x03, 0x01, 0x00, 0x02, 0x02, 0x46};
    error_code ignored;
    stream_.next_layer().non_blocking(true, ignored);
    stream_.next_layer().write_some(asio::buffer(alert), ignored);
  }

  // What the peer's alert says. In TLS 1.3 the side that connects learns only from its first read that it is refused.
  std::optional<StreamFailure> told_by_peer(error_code error) const {
    if (error.category() != asio::error::get_ssl_category()) return {};
    switch (ERR_GET_REASON(static_cast<unsigned long>(error.value()))) {
      case SSL_R_TLSV1_ALERT_UNKNOWN_CA:
        return StreamFailure{
            "session.failed.not_trusted_there",
            there() + "the peer does not trust this lab's certificate; there: arkmesh keys trust FILE.crt"};
      case SSL_R_SSLV3_ALERT_CERTIFICATE_REVOKED:
        return StreamFailure{"session.failed.revoked_there", there() + "the peer has revoked this lab's certificate"};
      default:
        return {};
    }
  }

  // Who it says it is, and the digits to compare.
  std::string describe_shown() const {
    const auto pin = shown_ ? pin_of(*shown_) : std::nullopt;
    if (!pin) return {};
    const std::string name = name_in(*shown_);
    return fmt::format(" ({}fingerprint {})", name.empty() ? "" : fmt::format("it says it is lab {}, ", name),
                       fingerprint(*pin));
  }

  const std::shared_ptr<TlsKeys> keys_;
  const std::optional<Host> to_;
  const std::string expected_;
  const std::shared_ptr<Attempts> attempts_;  // shared with the link
  std::optional<HostLookup> lookup_;
  std::vector<tcp::endpoint> addresses_;
  std::vector<std::byte> record_;
  bool connecting_ = false, shaking_ = false, closed_ = false;
  X509Pointer shown_;  // while hands are shaken
  Pin pin_{};
  std::string peer_;
};

}  // namespace

std::unique_ptr<SocketStream> tls_stream(tcp::socket socket, std::shared_ptr<TlsKeys> keys) {
  return std::make_unique<TlsStream>(std::move(socket), std::move(keys), std::nullopt, "", nullptr);
}

std::unique_ptr<SocketStream> tls_stream(tcp::socket socket, std::shared_ptr<TlsKeys> keys, Host to,
                                         std::string expected, std::shared_ptr<Attempts> attempts) {
  return std::make_unique<TlsStream>(std::move(socket), std::move(keys), std::move(to), std::move(expected),
                                     std::move(attempts));
}

}  // namespace arkmesh::gateway
