#include "lab/operator/operator_key.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>

#include <array>
#include <charconv>
#include <stdexcept>
#include <string>

#include "hal/config/config.hpp"
#include "hal/config/guarded_file.hpp"

namespace arkmesh::lab {
namespace {

constexpr std::size_t key_bytes = 32;

// Empty when the text is not 64 hexadecimal digits.
std::vector<std::uint8_t> key_in(std::string_view text) {
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  std::vector<std::uint8_t> key(key_bytes);
  if (text.size() != 2 * key_bytes) return {};
  for (std::size_t i = 0; i < key_bytes; ++i) {
    const char* const digits = text.data() + 2 * i;
    if (const auto [end, error] = std::from_chars(digits, digits + 2, key[i], 16); end != digits + 2) return {};
  }
  return key;
}

}  // namespace

OperatorKey::OperatorKey(std::filesystem::path file) : file_(std::move(file)) {
  if (!file_.empty()) return;
  if (const auto folder = hal::user_folder(); !folder.empty()) file_ = folder / "operator.key";
}

bool OperatorKey::make() const {
  if (file_.empty()) throw hal::ConfigError("no folder for the operator key: the variable HOME is not set");
  std::error_code error;
  if (std::filesystem::exists(file_, error)) return false;
  std::array<std::uint8_t, key_bytes> key{};
  if (RAND_bytes(key.data(), static_cast<int>(key.size())) != 1)
    throw std::runtime_error("OpenSSL returns no random bytes; is its package libssl3 intact?");
  std::string text;
  for (const std::uint8_t byte : key) text += fmt::format("{:02x}", byte);
  hal::write_guarded(file_, text + '\n', hal::secret_mode);
  return true;
}

void OperatorKey::read() {
  const auto text = file_.empty() ? std::nullopt : hal::read_guarded(file_, true);
  if (!text)
    throw hal::ConfigError(fmt::format("there is no operator key{}; arkmesh pause and similar commands create it",
                                       file_.empty() ? "" : " " + file_.string()));
  std::vector<std::uint8_t> key = key_in(*text);
  if (key.empty())
    throw hal::ConfigError(
        fmt::format("{} is not an operator key; remove it, and the next command creates another", file_.string()));
  key_ = std::move(key);
}

std::optional<std::vector<std::uint8_t>> OperatorKey::prove(std::span<const std::uint8_t> bytes) const {
  std::vector<std::uint8_t> proof(proof_bytes);
  unsigned int size = 0;
  if (key_.empty() ||
      !HMAC(EVP_sha256(), key_.data(), static_cast<int>(key_.size()), bytes.data(), bytes.size(), proof.data(),
            &size) ||
      size != proof_bytes)
    return {};
  return proof;
}

bool OperatorKey::proves(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> proof) const {
  const auto right = prove(bytes);
  return right && proof.size() == proof_bytes && CRYPTO_memcmp(right->data(), proof.data(), proof_bytes) == 0;
}

}  // namespace arkmesh::lab
