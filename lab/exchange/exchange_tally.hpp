// What the exchange between labs cost and how fresh it was, for result.json: messages, bytes, payloads and events by
// direction, and how old that was which boundaries applied. Nothing of it reaches a lab's behaviour.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "lab/exchange/confirmations.hpp"
#include "lab/exchange/exchange.hpp"
#include "lab/exchange/lab_state.hpp"
#include "lab/exchange/world_message.hpp"

namespace arkmesh::lab {

class ExchangeTally {
 public:
  // The own message of `bytes` went to the bus; a gateway sends it to every peer.
  void sent(const WorldMessage& message, std::size_t bytes) { own_.add(message, bytes); }
  void heard(std::string_view peer, const WorldMessage& message, std::size_t bytes) {
    auto known = peers_.find(peer);
    if (known == peers_.end()) known = peers_.emplace(peer, Peer{}).first;
    known->second.way.add(message, bytes);
  }
  // Applied at a boundary after the first; `own` is skipped.
  void applied(const std::vector<MergedState>& merged, std::string_view own, std::string_view owner,
               const Exchange& exchange);
  void told_early() { ++early_; }

  // As "exchange" of result.json (docs/formats.md).
  nlohmann::json json(const Exchange& exchange, const Confirmations& events) const;

 private:
  struct Way {
    std::uint64_t messages = 0, bytes = 0, payloads = 0, events = 0;
    void add(const WorldMessage& message, std::size_t bytes);
    nlohmann::json json() const;
  };
  struct Peer {
    Way way;
    std::uint64_t applied = 0, age_sum = 0, age_most = 0;
  };
  Way own_;
  std::map<std::string, Peer, std::less<>> peers_;
  std::uint64_t early_ = 0;
};

}  // namespace arkmesh::lab
