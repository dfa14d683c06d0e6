// What a lab has signed with its private key, for whoever trusts its certificate. Pure.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace arkmesh::gateway {

using Signature = std::array<std::uint8_t, 64>;

// Ed25519; nothing when the key is of another kind.
std::optional<Signature> sign(const std::string& key_pem, std::span<const std::uint8_t> bytes);
bool has_signed(const std::string& certificate_pem, std::span<const std::uint8_t> bytes,
                std::span<const std::uint8_t> signature);

}  // namespace arkmesh::gateway
