#include "gateway/links/tls_keys.hpp"

#include <fmt/format.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "hal/config/config.hpp"

namespace arkmesh::gateway {
namespace {

namespace ssl = boost::asio::ssl;

// Of what keep_shown() attaches to a connection.
int shown_index() {
  static const int index = SSL_get_ex_new_index(0, nullptr, nullptr, nullptr, nullptr);
  return index;
}

// Instead of OpenSSL's own check of chains, authorities and dates: the key alone decides. The error chooses what the
// peer is told.
int check_peer(X509_STORE_CTX* shown, void* keys) {
  X509* const certificate = X509_STORE_CTX_get0_cert(shown);
  auto* const connection = static_cast<SSL*>(X509_STORE_CTX_get_ex_data(shown, SSL_get_ex_data_X509_STORE_CTX_idx()));
  if (auto* const into = static_cast<X509Pointer*>(SSL_get_ex_data(connection, shown_index())); into && certificate) {
    X509_up_ref(certificate);
    into->reset(certificate);
  }
  const auto pin = certificate ? pin_of(*certificate) : std::nullopt;
  const auto verdict = pin ? static_cast<const TlsKeys*>(keys)->judge(*pin) : TlsKeys::Verdict{};
  if (verdict.standing == TlsKeys::Verdict::trusted) return 1;
  X509_STORE_CTX_set_error(shown, verdict.standing == TlsKeys::Verdict::revoked
                                      ? X509_V_ERR_CERT_REVOKED
                                      : X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT);
  return 0;
}

std::unique_ptr<ssl::context> make_context(const KeyFolder::Own& own, TlsKeys& keys) {
  auto context = std::make_unique<ssl::context>(ssl::context::tls);
  SSL_CTX* const native = context->native_handle();
  const X509Pointer certificate = parse_certificate(own.certificate.pem);
  const KeyPointer key = parse_key(own.key_pem);
  // Nothing is resumed: each connection shows its certificates anew.
  SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_options(native, SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION);
  SSL_CTX_set_verify(native, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
  SSL_CTX_set_cert_verify_callback(native, check_peer, &keys);
  SSL_CTX_set_max_cert_list(native, static_cast<long>(max_certificate_bytes));
  if (SSL_CTX_set_min_proto_version(native, TLS1_3_VERSION) != 1 || SSL_CTX_set_num_tickets(native, 0) != 1 ||
      SSL_CTX_use_certificate(native, certificate.get()) != 1 || SSL_CTX_use_PrivateKey(native, key.get()) != 1)
    throw hal::ConfigError(
        fmt::format("OpenSSL cannot use the key of lab {}; create another: arkmesh keys renew {} --new-key",
                    own.certificate.lab, own.certificate.lab));
  return context;
}

std::map<Pin, Certificate> by_pin(std::vector<Certificate> certificates) {
  std::map<Pin, Certificate> all;
  for (Certificate& each : certificates) {
    const Pin pin = each.pin;
    all.try_emplace(pin, std::move(each));
  }
  return all;
}

}  // namespace

TlsKeys::TlsKeys(KeyFolder folder, std::string lab)
    : folder_(std::move(folder)), lab_(std::move(lab)), stamp_(folder_.stamp()) {
  read();
}

void TlsKeys::read() {
  KeyFolder::Listing listing = folder_.list();
  trusted_ = by_pin(std::move(listing.trusted));
  revoked_ = by_pin(std::move(listing.revoked));
  errors_ = std::move(listing.damaged);
  KeyFolder::Own own = folder_.own(lab_);
  context_ = make_context(own, *this);
  std::vector<Certificate> let_in;
  for (const auto& [pin, each] : trusted_)
    if (!revoked_.contains(pin)) let_in.push_back(each);
  seals_ = Seals(own.key_pem, own.certificate.pin, let_in);
  own_ = std::move(own.certificate);
}

void TlsKeys::keep_shown(SSL* connection, X509Pointer& into) {
  SSL_set_ex_data(connection, shown_index(), &into);
}

void TlsKeys::refresh() {
  const std::string stamp = folder_.stamp();
  if (stamp == stamp_) return;
  try {
    read();
    stamp_ = stamp;  // of before: a change since then is read the next time
  } catch (const std::runtime_error& error) {
    errors_ = {error.what()};
  }
}

TlsKeys::Verdict TlsKeys::judge(const Pin& pin) const {
  if (const auto found = revoked_.find(pin); found != revoked_.end()) return {Verdict::revoked, found->second.lab};
  if (const auto found = trusted_.find(pin); found != trusted_.end()) return {Verdict::trusted, found->second.lab};
  return {};
}

void TlsKeys::saw(const Pin& pin, std::chrono::system_clock::time_point until) {
  if (trusted_.contains(pin)) seen_[pin] = until;
}

std::optional<long> TlsKeys::days_left(const std::string& lab) const {
  const Certificate* certificate = lab == lab_ ? &own_ : nullptr;
  for (const auto& [pin, each] : trusted_)
    if (each.lab == lab) certificate = &each;
  if (!certificate) return {};
  const auto seen = seen_.find(certificate->pin);
  const auto until = seen == seen_.end() ? certificate->until : std::max(certificate->until, seen->second);
  const auto left = until - std::chrono::system_clock::now();
  if (left > expiry_notice) return {};
  return std::chrono::floor<std::chrono::days>(left).count();
}

}  // namespace arkmesh::gateway
