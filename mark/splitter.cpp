#include "mark/splitter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace arkmesh::mark {
namespace {

constexpr std::size_t longest_robots = 5 * 400;

// Fit for people, whatever came.
std::string printable(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 40)) out += c >= ' ' && c <= '~' ? c : '.';
  return text.size() > 40 ? out + "..." : out;
}

bool is_bit_at(std::string_view text, std::size_t i) {
  return text[i] == '0' || text[i] == '1';
}

}  // namespace

Splitter::Splitter(const Grammar& grammar) : grammar_(grammar) {
  if (grammar_.experiment == Experiment::cre) {
    longest_ = grammar_.role == Role::server ? places : longest_robots;
    return;
  }
  const auto both = [&](Word word, std::string_view (*text)(Flavour)) {
    for (const Flavour each : {Flavour::argos, Flavour::ark_qt}) fixed_.push_back({word, std::string(text(each))});
  };
  if (grammar_.role == Role::server) {
    both(Word::missing, missing_text);
    both(Word::ack, ack_text);
    levels_first_ = 'T';
  } else {
    fixed_.push_back({Word::banner, std::string(banner_text)});
    fixed_.push_back({Word::stopped, std::string(stop_text)});
    levels_first_ = 'A';
    levels_word_ = Word::accomplished;
  }
  longest_ = 1 + 3 * most_sites;
}

void Splitter::reset() {
  rest_.clear();
  skipping_ = false;
}

std::vector<Message> Splitter::feed(std::string_view bytes) {
  std::vector<Message> out;
  grammar_.flavour == Flavour::argos ? feed_ended(bytes, out) : feed_endless(bytes, out);
  return out;
}

void Splitter::refuse(std::string_view why, std::string_view text, std::string_view what) {
  counters_.add(fmt::format("mark.refused.{}", why));
  counters_.add("mark.refused_bytes", text.size());
  newest_refusal_ = fmt::format("'{}' {}", printable(text), what);
}

// ---------------------------------------------------------------- ARGoS: a NUL after each message

void Splitter::feed_ended(std::string_view bytes, std::vector<Message>& out) {
  for (const char c : bytes) {
    if (c == '\0') {
      if (!std::exchange(skipping_, false)) classify(out);
      rest_.clear();
    } else if (skipping_) {
      counters_.add("mark.refused_bytes");
    } else {
      rest_ += c;
      if (rest_.size() <= longest_) continue;
      refuse("too_long", rest_,
             "is longer than any message; an original that sends no NUL bytes is ARK-Qt (mark.flavour)");
      rest_.clear();
      skipping_ = true;
    }
  }
}

void Splitter::classify(std::vector<Message>& out) {
  if (grammar_.experiment == Experiment::dhtf) {
    if (!classify_dhtf(out)) refuse("unknown", rest_, "is not one of its messages");
  } else if (grammar_.role == Role::server) {
    if (read_resources(rest_)) return out.push_back({Word::resources, rest_});
    refuse("resources", rest_, "is not 100 digits 0 or 1, one for each place");
  } else {
    if (read_robots(rest_, grammar_.side_cm)) return out.push_back({Word::robots, rest_});
    refuse("robots", rest_,
           fmt::format("is not five digits for each robot, with positions from 0 to {} cm", grammar_.side_cm));
  }
}

// False: no such message.
bool Splitter::classify_dhtf(std::vector<Message>& out) {
  if (const auto known = std::ranges::find(fixed_, rest_, &Message::text); known != fixed_.end()) {
    out.push_back(*known);
    return true;
  }
  const bool from_server = grammar_.role == Role::client;
  if (rest_.empty() && from_server) return out.push_back({Word::empty, {}}), true;
  if (rest_.starts_with('I') && from_server) {
    if (read_init(rest_))
      out.push_back({Word::init, rest_});
    else
      refuse("init", rest_, "is not I, letters from a to p in ascending order, and two digits 0 or 1 for each");
    return true;
  }
  if (!rest_.starts_with(levels_first_)) return false;
  if (read_levels(rest_, grammar_.sites))
    out.push_back({levels_word_, rest_});
  else
    refuse("levels", rest_, fmt::format("is not {} digits 0 or 1, one for each site", grammar_.sites));
  return true;
}

// ---------------------------------------------------------------- ARK-Qt: letters and lengths

void Splitter::feed_endless(std::string_view bytes, std::vector<Message>& out) {
  // In parts, so that what waits stays short whatever comes at once.
  for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), longest_))) {
    rest_ += bytes.substr(0, longest_);
    while (!rest_.empty()) {
      const std::size_t used = take(out);
      if (used == 0) break;
      rest_.erase(0, used);
    }
  }
}

// Refuses so many bytes; what follows is looked through for the letter of a message.
std::size_t Splitter::skip(std::string_view why, std::size_t bytes, std::string_view what) {
  refuse(why, std::string_view(rest_).substr(0, bytes), what);
  skipping_ = true;
  return bytes;
}

std::size_t Splitter::take(std::vector<Message>& out) {
  const char first = rest_.front();
  // Digits behind something refused belong to that.
  const bool begins = std::ranges::any_of(fixed_, [&](const Message& m) { return m.text[0] == first; }) ||
                      first == levels_first_ || (first == 'I' && grammar_.role == Role::client);
  if (skipping_ && (!begins || first == stop_text[0])) {
    counters_.add("mark.refused_bytes");
    return 1;
  }
  if (first == '\0') return skip("nul", 1, "ends a message, as ARGoS does (mark.flavour)");
  if (!begins) return skip("unknown", 1, "does not begin one of its messages");
  if (first == levels_first_) return take_levels(out);
  return first == 'I' ? take_init(out) : take_fixed(out);
}

std::size_t Splitter::take_fixed(std::vector<Message>& out) {
  bool unfinished = false;
  for (const Message& each : fixed_) {
    if (rest_.starts_with(each.text)) {
      out.push_back(each);
      skipping_ = false;
      return each.text.size();
    }
    unfinished = unfinished || each.text.starts_with(rest_);
  }
  return unfinished ? 0 : skip("unknown", 1, "begins no message of it");
}

std::size_t Splitter::take_levels(std::vector<Message>& out) {
  const std::size_t whole = grammar_.sites + 1;
  for (std::size_t i = 1; i < std::min(whole, rest_.size()); ++i)
    if (!is_bit_at(rest_, i))
      return skip("levels", i, fmt::format("is not a digit 0 or 1 for each of {} sites", grammar_.sites));
  if (rest_.size() < whole) return 0;
  out.push_back({levels_word_, rest_.substr(0, whole)});
  skipping_ = false;
  return whole;
}

// As many digits as twice the letters: letters tell how long it is.
std::size_t Splitter::take_init(std::vector<Message>& out) {
  constexpr std::string_view wrong = "is not I, letters a to p that ascend, and two digits 0 or 1 for each";
  std::size_t letters = 0;
  while (1 + letters < rest_.size() && rest_[1 + letters] >= 'a' && rest_[1 + letters] <= 'p') ++letters;
  if (letters > most_sites) return skip("init", 1 + letters, wrong);
  if (1 + letters == rest_.size()) return 0;
  const std::size_t whole = 1 + 3 * letters;
  for (std::size_t i = 1 + letters; i < std::min(whole, rest_.size()); ++i)
    if (!is_bit_at(rest_, i)) return skip("init", i, wrong);
  if (rest_.size() < whole) return 0;
  const std::string text = rest_.substr(0, whole);
  if (!read_init(text)) return skip("init", whole, wrong);
  out.push_back({Word::init, text});
  skipping_ = false;
  return whole;
}

}  // namespace arkmesh::mark
