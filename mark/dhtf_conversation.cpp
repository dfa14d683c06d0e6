#include "mark/dhtf_conversation.hpp"

#include <fmt/format.h>

namespace arkmesh::mark {

// ---------------------------------------------------------------- the original is the client

void DhtfServerConversation::hear(const Message& message) {
  switch (message.word) {
    case Word::missing:  // also one that began anew on the same connection
      acked_ = false;
      ready_.assign(ready_.size(), 0);
      break;
    case Word::ack:
      acked_ = init_.has_value();
      break;
    case Word::ready:
      if (const auto levels = read_levels(message.text, ready_.size())) ready_ = *levels;
      break;
    default:
      break;
  }
}

std::optional<std::string> DhtfServerConversation::say() const {
  if (!init_) return {};
  if (!acked_) return to_text(*init_);
  return to_text('A', inactive_);
}

// ---------------------------------------------------------------- the original is the server

void DhtfClientConversation::hear(const Message& message) {
  switch (message.word) {
    case Word::init:
      hear_init(message.text);
      break;
    case Word::empty:
      knows_us_ = go_;
      break;
    case Word::accomplished:
      knows_us_ = go_;
      hear_accomplished(message.text);
      break;
    default:
      break;
  }
}

void DhtfClientConversation::hear_init(const std::string& text) {
  const auto init = read_init(text);
  if (!init) return;
  knows_us_ = false;
  if (init->cells.size() != ready_.size())
    return conflict(
        fmt::format("{}: scenario.dhtf.sites = {}, and the Init of the original server has {} sites ('{}'): "
                    "set scenario.dhtf.sites = {} in all labs",
                    file_, ready_.size(), init->cells.size(), text, init->cells.size()));
  if (init_ && *init != *init_)
    return conflict(
        fmt::format("{}: the original server was '{}' and came back as '{}': its sites cannot change in a "
                    "run; start all labs again",
                    file_, to_text(*init_), text));
  init_ = init;
}

void DhtfClientConversation::hear_accomplished(const std::string& text) {
  const auto levels = read_levels(text, inactive_.size());
  if (!levels) return;
  for (std::size_t i = 0; i < levels->size(); ++i) executed_[i] += (*levels)[i] == 1 && inactive_[i] == 0;
  inactive_ = *levels;
}

std::optional<std::string> DhtfClientConversation::say() const {
  if (!init_ || !go_) return std::string(missing_text(flavour_));
  if (!knows_us_) return std::string(ack_text(flavour_));
  if (ended_) return to_text('T', std::vector<int>(ready_.size(), 0));
  // A site that it has closed is not ready, whatever boundaries have told so far.
  std::vector<int> ready = ready_;
  for (std::size_t i = 0; i < ready.size(); ++i) ready[i] = ready[i] == 1 && inactive_[i] == 0;
  return to_text('T', ready);
}

}  // namespace arkmesh::mark
