// Arbitrary bytes as they come from nodes, in arbitrary pieces: every byte is in a message or counted, messages are
// what a writer could have written, and no description gives a variable outside the node's memory.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "hal/platforms/aseba/protocol.hpp"

using namespace arkmesh::hal::aseba;

static void require(bool condition) {
  if (!condition) std::abort();
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  MessageReader reader, whole;
  Description about;
  std::span<const std::uint8_t> rest(data, size);
  std::vector<Message> in_pieces;
  std::uint64_t bytes = 0;
  for (std::size_t piece = 1; !rest.empty(); piece = piece * 7 % 61 + 1) {
    const auto now = rest.first(std::min(piece, rest.size()));
    rest = rest.subspan(now.size());
    for (Message& message : reader.read(now)) in_pieces.push_back(std::move(message));
  }
  require(in_pieces == whole.read({data, size}));
  for (const Message& message : in_pieces) {
    require(message.payload.size() <= largest_payload);
    MessageReader again;
    require(again.read(encode(message)) == std::vector{message});
    bytes += encode(message).size();
    require(words_of(message).size() == message.payload.size() / 2);
    if (message.type != description && message.type != variable_named) continue;
    if (!about.take(message)) require(about.all().empty() && !about.complete());
    for (const auto& [name, variable] : about.all()) {
      require(variable.size > 0 && variable.start + variable.size <= 0xffff);
      require(about.find(name) == variable);
    }
  }
  for (const Message& message : reader.give_up()) bytes += encode(message).size();
  reader.cut();
  require(bytes + reader.damaged_bytes() == size);
  return 0;
}
