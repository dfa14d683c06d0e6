#include "lab/operator/operator_message.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace arkmesh::lab {

std::vector<std::uint8_t> proved_bytes(operator_command_t message) {
  std::fill(std::begin(message.proof), std::end(message.proof), 0);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

bool obeys(const lab_status_t& status, std::string_view lab) {
  return std::ranges::any_of(status.counters, [lab](const counter_t& counter) {
    return counter.name.starts_with(obeys_counter) && counter.name.substr(obeys_counter.size()) == lab;
  });
}

std::string not_obeyed(std::string_view by, std::string_view lab) {
  return fmt::format("{0} does not obey the operator of {1}: in the file of {0} safety.commands_from does not name {1}",
                     by, lab);
}

}  // namespace arkmesh::lab
