#include "gateway/frame/signature.hpp"

#include <openssl/evp.h>
#include <openssl/x509.h>

#include <memory>

#include "gateway/links/certificate.hpp"

namespace arkmesh::gateway {
namespace {

struct FreeDigest {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};
using DigestPointer = std::unique_ptr<EVP_MD_CTX, FreeDigest>;

}  // namespace

std::optional<Signature> sign(const std::string& key_pem, std::span<const std::uint8_t> bytes) {
  const KeyPointer key = parse_key(key_pem);
  const DigestPointer context(EVP_MD_CTX_new());
  Signature signature{};
  std::size_t size = signature.size();
  if (!key || !context || EVP_PKEY_get_id(key.get()) != EVP_PKEY_ED25519 ||
      EVP_DigestSignInit(context.get(), nullptr, nullptr, nullptr, key.get()) != 1 ||
      EVP_DigestSign(context.get(), signature.data(), &size, bytes.data(), bytes.size()) != 1 ||
      size != signature.size())
    return {};
  return signature;
}

bool has_signed(const std::string& certificate_pem, std::span<const std::uint8_t> bytes,
                std::span<const std::uint8_t> signature) {
  const X509Pointer certificate = parse_certificate(certificate_pem);
  EVP_PKEY* const key = certificate ? X509_get0_pubkey(certificate.get()) : nullptr;
  const DigestPointer context(EVP_MD_CTX_new());
  return key && context && EVP_PKEY_get_id(key) == EVP_PKEY_ED25519 &&
         EVP_DigestVerifyInit(context.get(), nullptr, nullptr, nullptr, key) == 1 &&
         EVP_DigestVerify(context.get(), signature.data(), signature.size(), bytes.data(), bytes.size()) == 1;
}

}  // namespace arkmesh::gateway
