// Signatures of the labs that the folder of keys trusts, as it is at the moment: a lab that is revoked counts no more.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>

namespace arkmesh::app {

class TrustedSignatures {
 public:
  // `keys`: gateway.keys; empty: the default folder.
  explicit TrustedSignatures(std::filesystem::path keys) : keys_(std::move(keys)) {}
  bool has_signed(const std::string& peer, std::span<const std::uint8_t> bytes,
                  std::span<const std::uint8_t> signature);

 private:
  void read();

  std::filesystem::path keys_;
  std::string stamp_;                               // of the folder when it was read
  std::map<std::string, std::string> certificate_;  // as PEM, by lab
};

}  // namespace arkmesh::app
