#include "lab/exchange/growth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace arkmesh::lab {
namespace {

constexpr std::size_t most_told = 4096;     // numbers in one message, but for a boundary that has more by itself
constexpr std::uint32_t silent_after = 16;  // own boundaries: a peer that was not heard for so long delays nobody
constexpr std::uint32_t frozen_after = 3;   // own boundaries without one of the owner's

std::size_t length_of(std::int64_t head) {
  return static_cast<std::size_t>(head & 0xffffffff);
}

// Its lengths fit.
bool is_whole(std::span<const std::int64_t> entry) {
  while (!entry.empty()) {
    if (entry[0] < 0 || length_of(entry[0]) >= entry.size()) return false;
    entry = entry.subspan(1 + length_of(entry[0]));
  }
  return true;
}

std::vector<std::int64_t> part_of(std::span<const std::int64_t> entry, std::int64_t piece) {
  for (; !entry.empty(); entry = entry.subspan(1 + length_of(entry[0])))
    if (entry[0] >> 32 == piece) {
      const auto part = entry.subspan(1, length_of(entry[0]));
      return {part.begin(), part.end()};
    }
  return {};
}

}  // namespace

void Growth::begin(std::uint32_t boundary, Rule rule) {
  boundary_ = boundary;
  rule_ = rule;
  now_ = std::exchange(arrived_, {});
  if (rule != Rule::follows || !now_.empty()) grew_at_ = boundary;
  if (!frozen({}).empty()) counters_.add("growth.frozen");
}

std::vector<Grown> Growth::pass(std::string_view piece, std::uint32_t boundary, std::vector<std::int64_t> happened) {
  const std::int64_t number = std::ranges::find(pieces_, piece) - pieces_.begin();
  if (number == std::ssize(pieces_)) pieces_.emplace_back(piece);
  if (rule_ == Rule::decides && !happened.empty()) {
    open_.push_back(number << 32 | std::ssize(happened));
    open_.insert(open_.end(), happened.begin(), happened.end());
  }
  std::vector<Grown> out;
  if (rule_ != Rule::follows) out.push_back({boundary, std::move(happened)});
  for (const Arrived& each : now_) out.push_back({each.period, part_of(each.entry, number)});
  return out;
}

void Growth::end() {
  now_.clear();
  if (rule_ == Rule::decides && !pieces_.empty()) log_.push_back(std::exchange(open_, {}));
}

std::vector<std::int64_t> Growth::told_from(std::int64_t first) const {
  std::vector<std::int64_t> out{first};
  for (auto each = log_.begin() + first; each != log_.end(); ++each) {
    if (out.size() > 1 && out.size() + each->size() >= most_told) break;
    out.push_back(std::ssize(*each));
    out.insert(out.end(), each->begin(), each->end());
  }
  return out;
}

// From what the slowest peer lacks on. If the newest is not reached so, each peer has its turn: one that has much to
// catch up, or says so, holds up nobody.
std::vector<std::int64_t> Growth::told() {
  if (pieces_.empty() || rule_ == Rule::alike) return {};
  if (rule_ == Rule::follows) return {lacks_};
  std::vector<std::int64_t> lacking;
  for (const auto& [name, peer] : peers_)
    if (boundary_ - peer.heard_at <= silent_after && peer.lacks < std::ssize(log_)) lacking.push_back(peer.lacks);
  if (lacking.empty()) return {};
  const std::int64_t slowest = std::ranges::min(lacking);
  std::size_t size = 0;
  for (auto each = log_.begin() + slowest; each != log_.end(); ++each) size += 1 + each->size();
  return told_from(size < most_told ? slowest : lacking[turn_++ % lacking.size()]);
}

void Growth::hear(std::string_view peer, bool is_owner, std::uint64_t run_id, std::span<const std::int64_t> told) {
  if (pieces_.empty() || rule_ == Rule::alike) return;
  if (rule_ == Rule::decides) {
    if (told.empty()) return;
    if (told.size() != 1 || told[0] < 0 || told[0] > std::ssize(log_)) return counters_.add("growth.refused.position");
    peers_.insert_or_assign(std::string(peer), Peer{told[0], boundary_});
    return;
  }
  if (!is_owner) return;
  if (owners_run_ == 0) owners_run_ = run_id;
  restarted_ = run_id != owners_run_;
  if (restarted_ || told.empty()) return;
  std::int64_t period = told[0];
  if (period < 0 || period > lacks_) return;  // it will come: the owner is told what this lab lacks
  for (told = told.subspan(1); !told.empty(); ++period) {
    if (told[0] < 0 || std::cmp_greater_equal(told[0], told.size())) return counters_.add("growth.refused.length");
    const auto entry = told.subspan(1, static_cast<std::size_t>(told[0]));
    told = told.subspan(1 + entry.size());
    if (period < lacks_) continue;
    if (!is_whole(entry)) return counters_.add("growth.refused.length");
    arrived_.push_back({static_cast<std::uint32_t>(lacks_++), Entry(entry.begin(), entry.end())});
  }
}

std::string Growth::frozen(std::string_view owner) const {
  if (rule_ != Rule::follows || pieces_.empty() || boundary_ - grew_at_ < frozen_after) return {};
  std::string out = fmt::format("growing fields are frozen without {}", owner);
  if (lacks_ > 0) out += fmt::format(" since its period {}", lacks_ - 1);
  if (restarted_) out += ", which was restarted and has lost them: start all labs again";
  return out;
}

}  // namespace arkmesh::lab
