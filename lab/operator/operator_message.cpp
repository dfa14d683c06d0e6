#include "lab/operator/operator_message.hpp"

#include <algorithm>
#include <iterator>

namespace arkmesh::lab {

std::vector<std::uint8_t> proved_bytes(operator_command_t message) {
  std::fill(std::begin(message.proof), std::end(message.proof), 0);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace arkmesh::lab
