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

std::string word_of(int command) {
  const auto word = std::ranges::find(operator_words, command, &OperatorWord::command);
  return word == std::end(operator_words) ? std::to_string(command) : std::string(word->name);
}

operator_command_t question() {
  operator_command_t ask{};
  ask.command.command = operator_command_t::ask;
  return ask;
}

std::string not_obeyed(std::string_view by, std::string_view lab) {
  return fmt::format(
      "{0} does not accept commands from {1}'s operator: safety.commands_from in the file of {0} does not name {1}", by,
      lab);
}

std::string not_reached(std::string_view lab) {
  return fmt::format(
      "{0} does not answer this lab's operator; does this lab's gateway export operator_command, and does that of {0} "
      "import it?",
      lab);
}

}  // namespace arkmesh::lab
