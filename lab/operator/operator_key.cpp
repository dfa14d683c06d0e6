#include "lab/operator/operator_key.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>

#include <stdexcept>
#include <string>

#include "arkmesh/operator_command_t.hpp"
#include "hal/config/config.hpp"
#include "hal/config/guarded_file.hpp"

namespace arkmesh::lab {
namespace {

constexpr std::size_t key_bytes = 32, proof_bytes = sizeof(operator_command_t::proof);

}  // namespace

OperatorKey::OperatorKey(std::filesystem::path file) : file_(std::move(file)) {
  if (!file_.empty()) return;
  if (const auto folder = hal::user_folder(); !folder.empty()) file_ = folder / "operator.key";
}

bool OperatorKey::make() const {
  if (file_.empty()) throw hal::ConfigError("no folder for the operator key: the variable HOME is not set");
  std::error_code error;
  if (std::filesystem::exists(file_, error)) return false;
  std::vector<std::uint8_t> key(key_bytes);
  if (RAND_bytes(key.data(), static_cast<int>(key.size())) != 1)
    throw std::runtime_error("OpenSSL returns no random bytes; is its package libssl3 intact?");
  hal::write_guarded(file_, fmt::format("{:02x}\n", fmt::join(key, "")), hal::secret_mode);
  return true;
}

void OperatorKey::read() {
  auto text = file_.empty() ? std::nullopt : hal::read_guarded(file_, true);
  if (!text)
    throw hal::ConfigError(fmt::format("there is no operator key{}; arkmesh pause and similar commands create it",
                                       file_.empty() ? "" : " " + file_.string()));
  while (text->ends_with('\n')) text->pop_back();
  std::vector<std::uint8_t> key(key_bytes);
  std::size_t size = 0;
  if (OPENSSL_hexstr2buf_ex(key.data(), key.size(), &size, text->c_str(), '\0') != 1 || size != key_bytes)
    throw hal::ConfigError(
        fmt::format("{} is not an operator key; remove it, and the next command creates another", file_.string()));
  key_ = std::move(key);
}

std::optional<std::vector<std::uint8_t>> OperatorKey::prove(std::span<const std::uint8_t> bytes) const {
  std::vector<std::uint8_t> proof(proof_bytes);
  if (key_.empty() || !HMAC(EVP_sha256(), key_.data(), static_cast<int>(key_.size()), bytes.data(), bytes.size(),
                            proof.data(), nullptr))
    return {};
  return proof;
}

bool OperatorKey::proves(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> proof) const {
  const auto right = prove(bytes);
  return right && proof.size() == proof_bytes && CRYPTO_memcmp(right->data(), proof.data(), proof_bytes) == 0;
}

}  // namespace arkmesh::lab
