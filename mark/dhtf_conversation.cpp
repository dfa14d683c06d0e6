#include "mark/dhtf_conversation.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "lab/exchange/peers.hpp"

namespace arkmesh::mark {

// ---------------------------------------------------------------- the original is the client

void DhtfServerConversation::hear(const Message& message) {
  switch (message.word) {
    case Word::missing:  // also one that began anew on the same connection
      acked_ = false;
      ready_.assign(ready_.size(), 0);
      break;
    case Word::ack:
      if (const auto n = std::ranges::count(inactive_, 1); n > 0 && init_ && !acked_)
        spdlog::warn("{} of the labs' sites are inactive; the original client counts their tasks as its own", n);
      acked_ = was_acked_ = init_.has_value();
      break;
    case Word::ready:
      // It keeps the Init of an earlier connection, and acknowledges no other.
      if (!was_acked_) return conflict("the original client uses the sites of another server; restart it and this lab");
      if (!std::exchange(acked_, true))
        spdlog::warn(
            "the original client continues with the sites of an earlier connection; if they came from other labs, "
            "restart it and all labs");
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
  if (!is_told_ && message.word != Word::init) return;  // of a world that may be another one
  switch (message.word) {
    case Word::init:
      hear_init(message.text);
      break;
    case Word::empty:
      acked_ = go_;
      break;
    case Word::accomplished:
      acked_ = go_;
      hear_accomplished(message.text);
      break;
    default:
      break;
  }
}

void DhtfClientConversation::hear_init(const std::string& text) {
  const auto init = read_init(text);
  if (!init) return;
  // ARK-Qt's may have left it before our acknowledgement arrived; one behind T is of an experiment that began anew.
  if (flavour_ == Flavour::argos || ready_said_) acked_ = ready_said_ = false;
  if (init->cells.size() != ready_.size())
    return conflict(
        fmt::format("{}: scenario.dhtf.sites = {}, but the Init of the original server has {} sites ('{}'); set "
                    "scenario.dhtf.sites = {} in all labs",
                    file_, ready_.size(), init->cells.size(), text, init->cells.size()));
  if (is_kept_ && *init != *init_)
    return conflict(fmt::format("{} the original server returned with another Init: '{}' before, '{}' now",
                                lab::Peers::all_again, to_text(*init_), text));
  init_ = init;
  is_told_ = true;
}

void DhtfClientConversation::hear_accomplished(const std::string& text) {
  const auto levels = read_levels(text, inactive_.size());
  if (!levels) return;
  for (std::size_t i = 0; i < levels->size(); ++i) {
    const bool is_done = (*levels)[i] == 1 && inactive_[i] == 0;
    executed_[i] += is_done;
    if (is_done && ended_)
      spdlog::warn("the original server completed the task of cell {} after the labs had ended; they do not count it",
                   init_->cells[i]);
  }
  inactive_ = *levels;
}

std::optional<std::string> DhtfClientConversation::say() const {
  if (!is_told_ || !go_) return std::string(missing_text(flavour_));
  if (!acked_) return std::string(ack_text(flavour_));
  if (ended_) return to_text('T', std::vector<int>(ready_.size(), 0));
  // A site that it has closed is not ready, whatever boundaries have told so far.
  std::vector<int> ready = ready_;
  for (std::size_t i = 0; i < ready.size(); ++i) ready[i] = ready[i] == 1 && inactive_[i] == 0;
  return to_text('T', ready);
}

// ARGoS may overwrite an acknowledgement before it looks, so that it hears it until it answers. ARK-Qt hears it once:
// it says nothing while that is the newest that it has heard.
void DhtfClientConversation::said() {
  if (!is_told_ || !go_ || flavour_ == Flavour::argos) return;
  ready_said_ = acked_;
  acked_ = true;
}

}  // namespace arkmesh::mark
