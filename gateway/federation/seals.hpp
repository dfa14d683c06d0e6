// How labs prove and hide what they say where somebody else forwards it: by the keys of their certificates (Ed25519),
// and by what two such keys have in common (X25519 of the same keys, as libsodium derives them). Pure, but for chance.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gateway/links/certificate.hpp"

namespace arkmesh::gateway {

using Bytes = std::span<const std::byte>;
// Of XChaCha20-Poly1305. Who has it reads and writes.
using SecretKey = std::array<unsigned char, 32>;

// Whom a lab can verify and speak to in secret.
struct OtherSeal {
  Pin pin{};
  std::array<unsigned char, 32> key{};  // Ed25519, public
  SecretKey shared{};                   // with this lab
  // That this lab has signed these bytes.
  bool has_signed(Bytes bytes, Bytes signature) const;
};

// A lab's own key, and the labs that it trusts.
class Seals {
 public:
  // Nobody's: signs nothing and trusts nobody.
  Seals() = default;
  // A key that is not Ed25519 cannot sign, and trusts nobody; certificates of other kinds are left out.
  Seals(const std::string& key_pem, const Pin& pin, const std::vector<Certificate>& trusted);

  bool can_sign() const { return can_sign_; }
  std::array<std::byte, 64> sign(Bytes bytes) const;
  const Pin& pin() const { return pin_; }
  // Null when the lab is not trusted.
  const OtherSeal* of(const std::string& lab) const;
  const std::map<std::string, OtherSeal>& others() const { return others_; }

 private:
  Pin pin_{};
  bool can_sign_ = false;
  std::array<unsigned char, 64> secret_{};
  std::map<std::string, OtherSeal> others_;
};

SecretKey new_secret_key();
// By chance that nobody can foresee; never 0.
std::uint64_t new_unguessable_number();

inline constexpr std::size_t seal_bytes = 24 + 16;
// `beside` is not hidden, but what was sealed beside it opens with it only.
std::vector<std::byte> seal(const SecretKey& key, Bytes plain, Bytes beside);
// Nothing when it was not sealed so.
std::optional<std::vector<std::byte>> unseal(const SecretKey& key, Bytes sealed, Bytes beside);

}  // namespace arkmesh::gateway
