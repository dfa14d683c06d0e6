// Whether another lab has signed something with its own key. A lab asks; who knows the labs' certificates answers.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace arkmesh::lab {

class PeerSignatures {
 public:
  virtual ~PeerSignatures() = default;
  // False for a lab that is not trusted, or not any more.
  virtual bool has_signed(const std::string& peer, std::span<const std::uint8_t> bytes,
                          std::span<const std::uint8_t> signature) = 0;
};

}  // namespace arkmesh::lab
