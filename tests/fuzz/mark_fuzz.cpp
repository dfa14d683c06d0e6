// Text of an original M-ARK peer, cut anywhere: must never crash, never keep more than a message, give the same
// messages however it is cut, and read back what it gave. The first byte chooses the grammar, the second where it is
// cut.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

#include "mark/cre_conversation.hpp"
#include "mark/dhtf_conversation.hpp"
#include "mark/splitter.hpp"

using namespace arkmesh::mark;

namespace {

// The longest is a flying swarm of 400.
constexpr std::size_t longest = 2000;

void hear(Conversation& conversation, const std::vector<Message>& messages) {
  for (const Message& message : messages) {
    conversation.hear(message);
    static_cast<void>(conversation.say());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  Grammar grammar;
  grammar.experiment = data[0] & 1 ? Experiment::cre : Experiment::dhtf;
  grammar.role = data[0] & 2 ? Role::client : Role::server;
  grammar.flavour = data[0] & 4 && grammar.experiment == Experiment::dhtf ? Flavour::ark_qt : Flavour::argos;
  grammar.sites = 1 + (data[0] >> 4);
  const std::string_view text(reinterpret_cast<const char*>(data) + 2, size - 2);

  Splitter whole(grammar), cut(grammar);
  const std::vector<Message> at_once = whole.feed(text);
  std::vector<Message> in_parts;
  for (std::size_t at = 0, step = 1 + data[1] % 31; at < text.size(); at += step) {
    for (Message& message : cut.feed(text.substr(at, step))) in_parts.push_back(std::move(message));
    if (cut.waiting() > longest) std::abort();
  }
  if (at_once != in_parts || whole.counters().all() != cut.counters().all()) std::abort();

  for (const Message& message : at_once) {
    if (message.word == Word::init && to_text(*read_init(message.text)) != message.text) std::abort();
    if (message.word == Word::robots && to_text(*read_robots(message.text, grammar.side_cm)) != message.text)
      std::abort();
    if (message.word == Word::resources && resources_text(*read_resources(message.text)) != message.text) std::abort();
  }
  DhtfServerConversation dhtf_client(grammar.sites);
  DhtfClientConversation dhtf_server(grammar.sites, grammar.flavour, "lab.toml");
  dhtf_server.go();
  CreServerConversation ground;
  CreClientConversation flying(2, grammar.side_cm, "lab.toml");
  for (Conversation* each : std::initializer_list<Conversation*>{&dhtf_client, &dhtf_server, &ground, &flying})
    hear(*each, at_once);
  return 0;
}
