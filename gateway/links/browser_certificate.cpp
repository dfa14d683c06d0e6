#include "gateway/links/browser_certificate.hpp"

#include <fmt/format.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <array>
#include <boost/asio/ip/address.hpp>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <utility>

#include "gateway/links/certificate.hpp"

namespace arkmesh::gateway {
namespace {

// Of OpenSSL's objects that this file makes.
struct Free {
  void operator()(BIO* it) const { BIO_free(it); }
  void operator()(X509_EXTENSION* it) const { X509_EXTENSION_free(it); }
};
template <class Object>
using Owned = std::unique_ptr<Object, Free>;

void succeed(bool good) {
  if (!good)
    throw std::runtime_error("OpenSSL cannot create a certificate for browsers; is its package libssl3 intact?");
}

std::string names_of(const std::vector<std::string>& hosts) {
  std::string out = "DNS:localhost";
  for (const std::string& host : hosts) {
    if (host.empty()) continue;
    boost::system::error_code none;
    boost::asio::ip::make_address(host, none);
    if (host.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-.:") !=
        std::string::npos)
      continue;
    out += fmt::format(",{}:{}", none ? "DNS" : "IP", none ? host.substr(0, host.find(':')) : host);
  }
  return out;
}

template <class Write>
std::string as_pem(Write write) {
  const Owned<BIO> out(BIO_new(BIO_s_mem()));
  succeed(out && write(out.get()) == 1);
  char* text = nullptr;
  const auto size = static_cast<std::size_t>(BIO_get_mem_data(out.get(), &text));
  return {text, size};
}

X509Pointer signed_with(EVP_PKEY* key, const std::string& common, const std::string& names) {
  X509Pointer made(X509_new());
  X509_NAME* const name = X509_get_subject_name(made.get());
  const Owned<X509_EXTENSION> extension(X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, names.c_str()));
  const auto now = std::chrono::system_clock::now();
  const std::time_t from = std::chrono::system_clock::to_time_t(now - std::chrono::days(1)),
                    until = std::chrono::system_clock::to_time_t(now + certificate_life);
  std::uint64_t serial = 0;
  succeed(extension && RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial) == 1 &&
          X509_set_version(made.get(), 2) == 1 &&  // 2 stands for version 3
          ASN1_INTEGER_set_uint64(X509_get_serialNumber(made.get()), serial >> 1 | 1) == 1 &&
          ASN1_TIME_set(X509_getm_notBefore(made.get()), from) &&
          ASN1_TIME_set(X509_getm_notAfter(made.get()), until) &&
          X509_NAME_add_entry_by_NID(name, NID_commonName, MBSTRING_ASC,
                                     reinterpret_cast<const unsigned char*>(common.data()),
                                     static_cast<int>(common.size()), -1, 0) == 1 &&
          X509_set_issuer_name(made.get(), name) == 1 && X509_set_pubkey(made.get(), key) == 1 &&
          X509_add_ext(made.get(), extension.get(), -1) == 1 && X509_sign(made.get(), key, EVP_sha256()) > 0);
  return made;
}

}  // namespace

BrowserCertificate browser_certificate(const std::string& lab, const std::vector<std::string>& hosts,
                                       std::string_view before) {
  const std::string common = lab + " (arkmesh)", names = names_of(hosts);
  const std::string title = fmt::format("{}: {}\n", common, names);  // the kept text's first line: whom it is of
  KeyPointer key = parse_key(before);
  if (!key) key.reset(EVP_EC_gen("P-256"));
  succeed(key != nullptr);
  X509Pointer certificate = before.starts_with(title) ? parse_certificate(before) : nullptr;
  if (!certificate || X509_verify(certificate.get(), key.get()) != 1 ||
      end_of(*certificate) < std::chrono::system_clock::now() + expiry_notice)
    certificate = signed_with(key.get(), common, names);
  std::array<unsigned char, 32> digest{};
  succeed(X509_digest(certificate.get(), EVP_sha256(), digest.data(), nullptr) == 1);
  BrowserCertificate out;
  for (const unsigned char byte : digest)
    out.fingerprint += fmt::format("{}{:02X}", out.fingerprint.empty() ? "" : ":", byte);
  out.pem = title + as_pem([&](BIO* to) {
              return PEM_write_bio_PrivateKey(to, key.get(), nullptr, nullptr, 0, nullptr, nullptr) == 1 &&
                     PEM_write_bio_X509(to, certificate.get()) == 1;
            });
  return out;
}

}  // namespace arkmesh::gateway
