#include "gateway/browser_certificate.hpp"

#include <fmt/format.h>
#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/kdf.h>
#include <openssl/obj_mac.h>
#include <openssl/param_build.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <array>
#include <boost/asio/ip/address.hpp>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "gateway/certificate.hpp"
#include "hal/config.hpp"

namespace arkmesh::gateway {
namespace {

// Of OpenSSL's objects that this file makes.
struct Free {
  void operator()(BIO* it) const { BIO_free(it); }
  void operator()(BIGNUM* it) const { BN_clear_free(it); }
  void operator()(EC_GROUP* it) const { EC_GROUP_free(it); }
  void operator()(EC_POINT* it) const { EC_POINT_free(it); }
  void operator()(EVP_PKEY_CTX* it) const { EVP_PKEY_CTX_free(it); }
  void operator()(OSSL_PARAM_BLD* it) const { OSSL_PARAM_BLD_free(it); }
  void operator()(OSSL_PARAM* it) const { OSSL_PARAM_free(it); }
  void operator()(X509_EXTENSION* it) const { X509_EXTENSION_free(it); }
};
template <class Object>
using Owned = std::unique_ptr<Object, Free>;

void succeed(bool good) {
  if (!good) throw std::runtime_error("OpenSSL cannot make a certificate for browsers; is its package libssl3 whole?");
}

using Secret = std::array<unsigned char, 48>;  // longer than the key, so that its remainder is even enough

Secret derived_from(EVP_PKEY* key) {
  std::array<unsigned char, 32> raw{};
  std::size_t size = raw.size();
  if (EVP_PKEY_get_id(key) != EVP_PKEY_ED25519 || EVP_PKEY_get_raw_private_key(key, raw.data(), &size) != 1)
    throw hal::ConfigError("the lab's key is no Ed25519 key, as `arkmesh keys init` makes it");
  constexpr std::string_view purpose = "arkmesh page for browsers, P-256";
  Secret out{};
  size = out.size();
  const Owned<EVP_PKEY_CTX> context(EVP_PKEY_CTX_new_id(EVP_PKEY_HKDF, nullptr));
  succeed(context && EVP_PKEY_derive_init(context.get()) == 1 &&
          EVP_PKEY_CTX_set_hkdf_md(context.get(), EVP_sha256()) == 1 &&
          EVP_PKEY_CTX_set1_hkdf_key(context.get(), raw.data(), static_cast<int>(raw.size())) == 1 &&
          EVP_PKEY_CTX_add1_hkdf_info(context.get(), reinterpret_cast<const unsigned char*>(purpose.data()),
                                      static_cast<int>(purpose.size())) == 1 &&
          EVP_PKEY_derive(context.get(), out.data(), &size) == 1);
  return out;
}

// The scalar is 1 to order - 1.
KeyPointer p256_key(const Secret& secret) {
  const Owned<EC_GROUP> group(EC_GROUP_new_by_curve_name(NID_X9_62_prime256v1));
  const Owned<BIGNUM> number(BN_bin2bn(secret.data(), static_cast<int>(secret.size()), nullptr)), scalar(BN_new()),
      most(BN_dup(EC_GROUP_get0_order(group.get())));
  const std::unique_ptr<BN_CTX, void (*)(BN_CTX*)> scratch(BN_CTX_new(), BN_CTX_free);
  succeed(BN_sub_word(most.get(), 1) == 1 && BN_mod(scalar.get(), number.get(), most.get(), scratch.get()) == 1 &&
          BN_add_word(scalar.get(), 1) == 1);
  const Owned<EC_POINT> point(EC_POINT_new(group.get()));
  succeed(EC_POINT_mul(group.get(), point.get(), scalar.get(), nullptr, nullptr, scratch.get()) == 1);
  std::array<unsigned char, 65> in_public{};
  succeed(EC_POINT_point2oct(group.get(), point.get(), POINT_CONVERSION_UNCOMPRESSED, in_public.data(),
                             in_public.size(), scratch.get()) == in_public.size());
  const Owned<OSSL_PARAM_BLD> builder(OSSL_PARAM_BLD_new());
  succeed(OSSL_PARAM_BLD_push_utf8_string(builder.get(), OSSL_PKEY_PARAM_GROUP_NAME, "prime256v1", 0) == 1 &&
          OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_PRIV_KEY, scalar.get()) == 1 &&
          OSSL_PARAM_BLD_push_octet_string(builder.get(), OSSL_PKEY_PARAM_PUB_KEY, in_public.data(),
                                           in_public.size()) == 1);
  const Owned<OSSL_PARAM> parameters(OSSL_PARAM_BLD_to_param(builder.get()));
  const Owned<EVP_PKEY_CTX> context(EVP_PKEY_CTX_new_from_name(nullptr, "EC", nullptr));
  EVP_PKEY* key = nullptr;
  succeed(context && EVP_PKEY_fromdata_init(context.get()) == 1 &&
          EVP_PKEY_fromdata(context.get(), &key, EVP_PKEY_KEYPAIR, parameters.get()) == 1);
  return KeyPointer(key);
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

}  // namespace

BrowserCertificate browser_certificate(std::string_view lab_key_pem, std::string_view lab_certificate_pem,
                                       const std::string& lab, const std::vector<std::string>& hosts,
                                       std::string_view before) {
  const KeyPointer of_lab = parse_key(lab_key_pem);
  const X509Pointer lab_certificate = parse_certificate(lab_certificate_pem);
  succeed(of_lab && lab_certificate);
  const KeyPointer key = p256_key(derived_from(of_lab.get()));
  const std::string common = lab + " (arkmesh)", names = names_of(hosts);
  X509Pointer made(X509_new());
  X509_NAME* const name = X509_get_subject_name(made.get());
  const Owned<X509_EXTENSION> extension(X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, names.c_str()));
  // All that the certificate says is in its number, by which another one is known.
  const auto until = static_cast<std::uint64_t>(end_of(*lab_certificate).time_since_epoch().count());
  const std::string all = fmt::format("{} {} {}", common, names, until);
  std::array<unsigned char, 32> digest{};
  succeed(EVP_Digest(all.data(), all.size(), digest.data(), nullptr, EVP_sha256(), nullptr) == 1);
  std::uint64_t serial = 0;
  std::memcpy(&serial, digest.data(), sizeof serial);
  succeed(extension && X509_set_version(made.get(), 2) == 1 &&  // 2 stands for version 3
          ASN1_INTEGER_set_uint64(X509_get_serialNumber(made.get()), serial >> 1 | 1) == 1 &&
          X509_set1_notBefore(made.get(), X509_get0_notBefore(lab_certificate.get())) == 1 &&
          X509_set1_notAfter(made.get(), X509_get0_notAfter(lab_certificate.get())) == 1 &&
          X509_NAME_add_entry_by_NID(name, NID_commonName, MBSTRING_ASC,
                                     reinterpret_cast<const unsigned char*>(common.data()),
                                     static_cast<int>(common.size()), -1, 0) == 1 &&
          X509_set_issuer_name(made.get(), name) == 1 && X509_set_pubkey(made.get(), key.get()) == 1 &&
          X509_add_ext(made.get(), extension.get(), -1) == 1);
  if (X509Pointer old = parse_certificate(before);
      old && X509_verify(old.get(), key.get()) == 1 &&
      ASN1_INTEGER_cmp(X509_get0_serialNumber(old.get()), X509_get0_serialNumber(made.get())) == 0)
    made = std::move(old);
  else
    succeed(X509_sign(made.get(), key.get(), EVP_sha256()) > 0);
  succeed(X509_digest(made.get(), EVP_sha256(), digest.data(), nullptr) == 1);
  BrowserCertificate out;
  for (const unsigned char byte : digest)
    out.fingerprint += fmt::format("{}{:02X}", out.fingerprint.empty() ? "" : ":", byte);
  out.certificate_pem = as_pem([&](BIO* to) { return PEM_write_bio_X509(to, made.get()); });
  out.key_pem =
      as_pem([&](BIO* to) { return PEM_write_bio_PrivateKey(to, key.get(), nullptr, nullptr, 0, nullptr, nullptr); });
  return out;
}

}  // namespace arkmesh::gateway
