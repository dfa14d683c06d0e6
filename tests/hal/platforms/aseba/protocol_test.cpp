// What Aseba's nodes say: bytes and back, damage, and descriptions that a node may not give.
#include "hal/platforms/aseba/protocol.hpp"

#include <doctest/doctest.h>

#include "hal/random.hpp"

using namespace arkmesh::hal::aseba;

namespace {

std::vector<std::uint8_t> bytes_of(const std::vector<Message>& messages) {
  std::vector<std::uint8_t> out;
  for (const Message& message : messages) {
    const auto bytes = encode(message);
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
  return out;
}

Message text(std::uint16_t type, const std::string& payload) {
  return {.source = 1, .type = type, .payload = {payload.begin(), payload.end()}};
}

// The beginning of the answer of a Thymio with two variables, and they.
const std::string about_thymio("\x09thymio-II\x05\0\xfe\x05\x20\0\x4a\x02\x02\0\x11\0\x34\0", 24);
const std::string one("\x01\0\x03_id", 6), two("\x20\0\x0a"
                                               "event.args",
                                               13);

}  // namespace

TEST_CASE("aseba: bytes on the line") {
  // A question is the bytes that the simulators of the makers understand, and what comes in any pieces is the same.
  CHECK(encode(make_message(get_variables, {3, 0x1234, 2})) ==
        std::vector<std::uint8_t>{6, 0, 0, 0, 0x0b, 0xa0, 3, 0, 0x34, 0x12, 2, 0});
  CHECK(words_of(make_message(set_variables, {1, -500, 70'000})) == std::vector<int>{1, -500, 4464});
  const std::vector<Message> said{make_message(2, {7, -8}), text(variable_named, one), make_message(list_nodes, {5})};
  for (const std::size_t piece : {1, 2, 5, 7, 100}) {
    MessageReader reader;
    std::vector<Message> heard;
    const auto all = bytes_of(said);
    for (std::size_t i = 0; i < all.size(); i += piece)
      for (const Message& message : reader.read(std::span(all).subspan(i, std::min(piece, all.size() - i))))
        heard.push_back(message);
    CHECK(heard == said);
    CHECK(reader.damaged_bytes() == 0);
    CHECK_FALSE(reader.waits());
  }
}

TEST_CASE("aseba: damage is skipped and counted") {
  // After a megabyte of any bytes and a pause, every message is heard, no byte is forgotten, and little is held.
  arkmesh::hal::RandomStream chance(3, "garbage");
  MessageReader reader;
  std::uint64_t in_messages = 0;
  for (int i = 0; i < 1000; ++i) {
    std::vector<std::uint8_t> garbage(1000);
    for (auto& byte : garbage) byte = static_cast<std::uint8_t>(chance.below(256));
    for (const Message& message : reader.read(garbage)) in_messages += header_bytes + message.payload.size();
  }
  reader.cut();
  CHECK(in_messages + reader.damaged_bytes() == 1'000'000);
  const std::vector<Message> said{make_message(node_present, {5}), make_message(1, {1, 2, 3})};
  CHECK(reader.read(bytes_of(said)) == said);
  // the rest of a message whose line was cut is not taken for the end of another
  const auto half = encode(said[1]);
  CHECK(reader.read(std::span(half).first(9)).empty());
  CHECK(reader.waits());
  reader.cut();
  CHECK(reader.read(bytes_of(said)) == said);
  // what was swallowed by something that began as a long message is found in it
  const std::vector<std::uint8_t> long_one{0x00, 0x04, 1, 0, 7, 0};
  CHECK(reader.read(long_one).empty());
  CHECK(reader.read(bytes_of(said)).empty());
  CHECK(reader.give_up() == said);
  CHECK_FALSE(reader.waits());
}

TEST_CASE("aseba: descriptions") {
  // Variables lie one after the other; a description that is damaged, too long, or of another order is refused whole.
  Description about;
  CHECK(about.take(text(description, about_thymio)));
  CHECK(about.name() == "thymio-II");
  CHECK(about.take(text(variable_named, one)));
  CHECK_FALSE(about.complete());
  CHECK(about.take(text(variable_named, two)));
  CHECK(about.complete());
  CHECK(about.find("event.args") == Variable{1, 32});
  CHECK_FALSE(about.find("event"));
  CHECK_FALSE(about.take(text(variable_named, one)));  // one more than was promised
  CHECK_FALSE(about.complete());
  CHECK_FALSE(about.take(text(variable_named, one)));  // none was promised

  const auto refused = [](const std::string& payload, const std::string& first = about_thymio) {
    Description other;
    CHECK(other.take(text(description, first)));
    return !other.take(text(variable_named, payload));
  };
  CHECK(refused(""));
  CHECK(refused(std::string("\x01\0\x04_id", 6)));    // the name is longer than the message
  CHECK(refused(std::string("\x01\0\x02_id", 6)));    // shorter
  CHECK(refused(std::string("\0\0\x03_id", 6)));      // of no words
  CHECK(refused(std::string("\x4b\x02\x03_id", 6)));  // of more words than the node has
  CHECK_FALSE(refused(std::string("\x4a\x02\x03_id", 6)));
  Description twice;
  CHECK(twice.take(text(description, about_thymio)));
  CHECK(twice.take(text(variable_named, one)));
  CHECK_FALSE(twice.take(text(variable_named, one)));
  for (const std::string& wrong : {std::string(), about_thymio.substr(1), about_thymio + "x", std::string("\xff", 1)})
    CHECK_FALSE(Description().take(text(description, wrong)));
  Description odd;
  std::string named = about_thymio;
  named[1] = '\n';
  CHECK(odd.take(text(description, named)));
  CHECK(odd.name() == "?hymio-II");
}
