// Splits the original's bytes, which TCP cuts and merges as it likes, into its messages, by their grammar. ARGoS ends a
// message with NUL; ARK-Qt with nothing, so that letters and lengths tell. Bytes that are no message are refused and
// counted, and the next message is looked for. Pure; holds never more than the longest message.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"
#include "mark/vocabulary.hpp"

namespace arkmesh::mark {

// Whose bytes they are.
struct Grammar {
  Experiment experiment = Experiment::dhtf;
  Role role = Role::server;  // of this side
  Flavour flavour = Flavour::argos;
  std::size_t sites = 8;  // M of DHTF
  int side_cm = 50;       // of the flying arena of CRE
};

class Splitter {
 public:
  explicit Splitter(const Grammar& grammar);

  // The messages that are complete with these bytes, in order.
  std::vector<Message> feed(std::string_view bytes);
  // The connection is another one.
  void reset();

  // `mark.refused.<why>` and `mark.refused_bytes`.
  const hal::Counters& counters() const { return counters_; }
  // What was wrong with the newest refused bytes, for people; empty when there were none.
  const std::string& newest_refusal() const { return newest_refusal_; }
  // Bytes of a message that is not complete.
  std::size_t waiting() const { return rest_.size(); }

 private:
  void refuse(std::string_view why, std::string_view text, std::string_view what);
  void feed_ended(std::string_view bytes, std::vector<Message>& out);
  void feed_endless(std::string_view bytes, std::vector<Message>& out);
  void classify(std::vector<Message>& out);
  bool classify_dhtf(std::vector<Message>& out);
  // One message, or bytes that are none, from the beginning of rest_: how many bytes; 0: more are needed.
  std::size_t take(std::vector<Message>& out);
  std::size_t take_fixed(std::vector<Message>& out);
  std::size_t take_levels(std::vector<Message>& out);
  std::size_t take_init(std::vector<Message>& out);
  std::size_t skip(std::string_view why, std::size_t bytes, std::string_view what);

  Grammar grammar_;
  std::vector<Message> fixed_;  // messages that are always alike, of the original's role
  char levels_first_ = 0;       // of those with a digit per site
  Word levels_word_ = Word::ready;
  std::size_t longest_ = 0;
  std::string rest_;
  bool skipping_ = false;  // until the next NUL, or letter
  hal::Counters counters_;
  std::string newest_refusal_;
};

}  // namespace arkmesh::mark
