#include "gateway/links/certificate.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>

#include <ctime>
#include <stdexcept>

#include "hal/arenas/messages.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::gateway {
namespace {

struct FreeBio {
  void operator()(BIO* bio) const { BIO_free(bio); }
};
using BioPointer = std::unique_ptr<BIO, FreeBio>;

BioPointer reader(std::string_view text) {
  return BioPointer(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

// The password of a key: nobody is there to type one.
int no_password(char*, int, int, void*) {
  return -1;
}

std::string taken(const BioPointer& bio) {
  char* text = nullptr;
  const auto size = static_cast<std::size_t>(BIO_get_mem_data(bio.get(), &text));
  return {text, size};
}

void must(bool good) {
  if (!good) throw std::runtime_error("OpenSSL cannot create a key or a certificate; is its package libssl3 intact?");
}

}  // namespace

void DeleteOpenssl::operator()(X509* certificate) const {
  X509_free(certificate);
}
void DeleteOpenssl::operator()(EVP_PKEY* key) const {
  EVP_PKEY_free(key);
}

X509Pointer parse_certificate(std::string_view pem) {
  if (pem.size() > max_certificate_bytes) return {};
  return X509Pointer(PEM_read_bio_X509(reader(pem).get(), nullptr, no_password, nullptr));
}

KeyPointer parse_key(std::string_view pem) {
  if (pem.size() > max_certificate_bytes) return {};
  return KeyPointer(PEM_read_bio_PrivateKey(reader(pem).get(), nullptr, no_password, nullptr));
}

std::optional<Pin> pin_of(const X509& certificate) {
  unsigned char* bytes = nullptr;
  const int size = i2d_X509_PUBKEY(X509_get_X509_PUBKEY(&certificate), &bytes);
  if (size <= 0) return {};
  Pin pin;
  const bool good = EVP_Digest(bytes, static_cast<std::size_t>(size), pin.data(), nullptr, EVP_sha256(), nullptr) == 1;
  OPENSSL_free(bytes);
  return good ? std::optional(pin) : std::nullopt;
}

std::chrono::system_clock::time_point end_of(const X509& certificate) {
  std::tm end{};
  if (ASN1_TIME_to_tm(X509_get0_notAfter(&certificate), &end) != 1) return {};
  return std::chrono::system_clock::from_time_t(::timegm(&end));
}

std::string name_in(const X509& certificate) {
  X509_NAME* const subject = X509_get_subject_name(&certificate);
  const int at = X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
  if (at < 0 || X509_NAME_get_index_by_NID(subject, NID_commonName, at) >= 0) return {};
  const ASN1_STRING* const text = X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, at));
  const std::string name(reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
                         static_cast<std::size_t>(ASN1_STRING_length(text)));
  return hal::is_lab_name(name) ? name : std::string();
}

Certificate read_certificate(std::string_view pem) {
  const X509Pointer parsed = parse_certificate(pem);
  if (!parsed) throw hal::ConfigError("is not a certificate; give the file LAB.crt that `arkmesh keys init LAB` makes");
  Certificate certificate{.lab = name_in(*parsed), .until = end_of(*parsed)};
  if (certificate.lab.empty())
    throw hal::ConfigError("is not a lab's certificate: its common name (CN) is not a lab name");
  const auto pin = pin_of(*parsed);
  if (!pin || X509_verify(parsed.get(), X509_get0_pubkey(parsed.get())) != 1)
    throw hal::ConfigError(fmt::format(
        "names lab {} but is not signed with its own key; ask that lab for its file again", certificate.lab));
  certificate.pin = *pin;
  const BioPointer out(BIO_new(BIO_s_mem()));
  must(PEM_write_bio_X509(out.get(), parsed.get()) == 1);
  certificate.pem = taken(out);
  return certificate;
}

std::string fingerprint(const Pin& pin) {
  std::string text;
  for (std::size_t group = 0; group < 5; ++group) {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < 6; ++i) number = number << 8 | pin[6 * group + i];
    text += fmt::format("{}{:05}", group == 0 ? "" : " ", number % 100'000);
  }
  return text;
}

std::string make_key() {
  const KeyPointer key(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519"));
  const BioPointer out(BIO_new(BIO_s_mem()));
  must(key && PEM_write_bio_PrivateKey(out.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) == 1);
  return taken(out);
}

std::string make_certificate(std::string_view key_pem, const std::string& lab,
                             std::chrono::system_clock::time_point now, std::chrono::days life) {
  const KeyPointer key = parse_key(key_pem);
  const X509Pointer made(X509_new());
  must(key && made);
  std::uint64_t serial = 0;
  must(RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial) == 1);
  std::time_t from = std::chrono::system_clock::to_time_t(now);
  X509_NAME* const name = X509_get_subject_name(made.get());
  const auto* const text = reinterpret_cast<const unsigned char*>(lab.data());
  must(X509_set_version(made.get(), 2) == 1 &&  // 2 stands for version 3
       ASN1_INTEGER_set_uint64(X509_get_serialNumber(made.get()), serial >> 1) == 1 &&
       X509_time_adj_ex(X509_getm_notBefore(made.get()), -1, 0, &from) &&
       X509_time_adj_ex(X509_getm_notAfter(made.get()), static_cast<int>(life.count()), 0, &from) &&
       X509_NAME_add_entry_by_NID(name, NID_commonName, MBSTRING_ASC, text, static_cast<int>(lab.size()), -1, 0) == 1 &&
       X509_set_issuer_name(made.get(), name) == 1 && X509_set_pubkey(made.get(), key.get()) == 1);
  const bool own_digest = EVP_PKEY_get_id(key.get()) == EVP_PKEY_ED25519;
  must(X509_sign(made.get(), key.get(), own_digest ? nullptr : EVP_sha256()) > 0);
  const BioPointer out(BIO_new(BIO_s_mem()));
  must(PEM_write_bio_X509(out.get(), made.get()) == 1);
  return taken(out);
}

}  // namespace arkmesh::gateway
