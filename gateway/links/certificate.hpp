// What a lab proves with that it is itself: a private key, and a certificate that names the lab and that its own key
// has signed. A certificate is known by its key alone, so its dates never shut anybody out, and a renewed one of the
// same key is as good. Pure, but for chance.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "hal/config/guarded_file.hpp"

struct x509_st;
struct evp_pkey_st;

namespace arkmesh::gateway {

// SHA-256 of a public key (DER, SubjectPublicKeyInfo).
using Pin = std::array<unsigned char, 32>;

struct Certificate {
  std::string lab;
  Pin pin{};
  std::chrono::system_clock::time_point until;
  std::string pem;
};

// Longer files are not read.
inline constexpr std::size_t max_certificate_bytes = hal::max_guarded_bytes;
// How long before a certificate's end people are told.
inline constexpr std::chrono::days expiry_notice{30};
inline constexpr std::chrono::days certificate_life{3650};

// Throws hal::ConfigError: what is wrong with the text, as the end of a sentence that begins with a file's name.
Certificate read_certificate(std::string_view pem);
// Of what a peer shows; nothing when it has no usable key.
std::optional<Pin> pin_of(const x509_st& certificate);
std::chrono::system_clock::time_point end_of(const x509_st& certificate);
// The lab that it says it is of; empty when that is no lab's name.
std::string name_in(const x509_st& certificate);

// 25 digits in groups of five, to compare by phone: 83 bits of the pin.
std::string fingerprint(const Pin& pin);

struct DeleteOpenssl {
  void operator()(x509_st* certificate) const;
  void operator()(evp_pkey_st* key) const;
};
using X509Pointer = std::unique_ptr<x509_st, DeleteOpenssl>;
using KeyPointer = std::unique_ptr<evp_pkey_st, DeleteOpenssl>;

// Null when the text holds none, or one behind a password.
X509Pointer parse_certificate(std::string_view pem);
KeyPointer parse_key(std::string_view pem);
// A new Ed25519 key, as PEM.
std::string make_key();
// A certificate for it from a day before `now` on. Throws std::runtime_error when the key is none.
std::string make_certificate(std::string_view key_pem, const std::string& lab,
                             std::chrono::system_clock::time_point now = std::chrono::system_clock::now(),
                             std::chrono::days life = certificate_life);

}  // namespace arkmesh::gateway
