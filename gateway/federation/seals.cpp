#include "gateway/federation/seals.hpp"

#include <openssl/evp.h>
#include <openssl/x509.h>
#include <sodium.h>

#include <stdexcept>

namespace arkmesh::gateway {
namespace {

static_assert(sizeof(SecretKey) == crypto_aead_xchacha20poly1305_ietf_KEYBYTES);
static_assert(sizeof(SecretKey) == crypto_box_BEFORENMBYTES);
static_assert(seal_bytes == crypto_aead_xchacha20poly1305_ietf_NPUBBYTES + crypto_aead_xchacha20poly1305_ietf_ABYTES);

constexpr std::size_t nonce_bytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;

void start_sodium() {
  static const int started = sodium_init();
  if (started < 0) throw std::runtime_error("libsodium cannot start: this machine gives it no randomness");
}

const unsigned char* in(Bytes bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}
unsigned char* out(std::byte* bytes) {
  return reinterpret_cast<unsigned char*>(bytes);
}

}  // namespace

bool OtherSeal::has_signed(Bytes bytes, Bytes signature) const {
  return signature.size() == crypto_sign_BYTES &&
         crypto_sign_verify_detached(in(signature), in(bytes), bytes.size(), key.data()) == 0;
}

Seals::Seals(const std::string& key_pem, const Pin& pin, const std::vector<Certificate>& trusted) : pin_(pin) {
  start_sodium();
  const KeyPointer own = parse_key(key_pem);
  std::array<unsigned char, crypto_sign_SEEDBYTES> seed{};
  std::array<unsigned char, crypto_sign_PUBLICKEYBYTES> own_public{};
  std::array<unsigned char, crypto_scalarmult_curve25519_BYTES> own_curve{}, curve{};
  std::size_t size = seed.size();
  if (!own || EVP_PKEY_get_id(own.get()) != EVP_PKEY_ED25519 ||
      EVP_PKEY_get_raw_private_key(own.get(), seed.data(), &size) != 1 || size != seed.size() ||
      crypto_sign_seed_keypair(own_public.data(), secret_.data(), seed.data()) != 0 ||
      crypto_sign_ed25519_sk_to_curve25519(own_curve.data(), secret_.data()) != 0)
    return;
  can_sign_ = true;
  for (const Certificate& each : trusted) {
    const X509Pointer certificate = parse_certificate(each.pem);
    EVP_PKEY* const key = certificate ? X509_get0_pubkey(certificate.get()) : nullptr;
    OtherSeal seal{.pin = each.pin};
    size = seal.key.size();
    if (!key || EVP_PKEY_get_id(key) != EVP_PKEY_ED25519 ||
        EVP_PKEY_get_raw_public_key(key, seal.key.data(), &size) != 1 || size != seal.key.size() ||
        crypto_sign_ed25519_pk_to_curve25519(curve.data(), seal.key.data()) != 0 ||
        crypto_box_beforenm(seal.shared.data(), curve.data(), own_curve.data()) != 0)
      continue;
    others_.emplace(each.lab, seal);
  }
  sodium_memzero(seed.data(), seed.size());
  sodium_memzero(own_curve.data(), own_curve.size());
}

std::array<std::byte, 64> Seals::sign(Bytes bytes) const {
  std::array<std::byte, crypto_sign_BYTES> signature{};
  crypto_sign_detached(out(signature.data()), nullptr, in(bytes), bytes.size(), secret_.data());
  return signature;
}

const OtherSeal* Seals::of(const std::string& lab) const {
  const auto found = others_.find(lab);
  return found == others_.end() ? nullptr : &found->second;
}

SecretKey new_secret_key() {
  start_sodium();
  SecretKey key;
  randombytes_buf(key.data(), key.size());
  return key;
}

std::uint64_t new_unguessable_number() {
  start_sodium();
  std::uint64_t number = 0;
  while (number == 0) randombytes_buf(&number, sizeof number);
  return number;
}

std::vector<std::byte> seal(const SecretKey& key, Bytes plain, Bytes beside) {
  std::vector<std::byte> sealed(seal_bytes + plain.size());
  randombytes_buf(sealed.data(), nonce_bytes);
  crypto_aead_xchacha20poly1305_ietf_encrypt(out(sealed.data() + nonce_bytes), nullptr, in(plain), plain.size(),
                                             in(beside), beside.size(), nullptr, out(sealed.data()), key.data());
  return sealed;
}

std::optional<std::vector<std::byte>> unseal(const SecretKey& key, Bytes sealed, Bytes beside) {
  if (sealed.size() < seal_bytes) return {};
  std::vector<std::byte> plain(sealed.size() - seal_bytes);
  if (crypto_aead_xchacha20poly1305_ietf_decrypt(out(plain.data()), nullptr, nullptr, in(sealed) + nonce_bytes,
                                                 sealed.size() - nonce_bytes, in(beside), beside.size(), in(sealed),
                                                 key.data()) != 0)
    return {};
  return plain;
}

}  // namespace arkmesh::gateway
