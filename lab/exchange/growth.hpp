// What grows over boundaries, such as stocks that robots use up and trails that they lay. Strict labs merge the same
// states, so each of them lets it grow by itself. Free labs merge different ones: there the owner of the shared world
// keeps a log of what happened at each of its boundaries and tells it until every peer has it, and the others apply
// that. So all hold the same after the same period of the owner, and a lost owner freezes it. Knows no time and no bus.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"

namespace arkmesh::lab {

// What a piece applies for one period.
struct Grown {
  std::uint32_t period = 0;            // the boundary of the lab that decides
  std::vector<std::int64_t> happened;  // as that lab had it; empty: nothing
};

class Growth {
 public:
  // Who decides what happened at a boundary: each lab alike; this lab, for all; the owner, which is another one.
  enum class Rule { alike, decides, follows };

  // At each boundary, around the scenario's on_period.
  void begin(std::uint32_t boundary, Rule rule);
  void end();

  // As Lab::grow; `boundary` is this lab's.
  std::vector<Grown> pass(std::string_view piece, std::uint32_t boundary, std::vector<std::int64_t> happened);

  // What the own `world` tells of it: of the owner the number of the first boundary that some peer lacks and then, for
  // each from there on, how many numbers it has, and these; of others the first boundary that they lack. Often empty.
  std::vector<std::int64_t> told();
  // What a peer told: of the owner, or of another lab. Anything may come.
  void hear(std::string_view peer, bool is_owner, std::uint64_t run_id, std::span<const std::int64_t> told);

  // Why it does not grow here, for the status; empty while it does.
  std::string frozen(std::string_view owner) const;
  const hal::Counters& counters() const { return counters_; }

 private:
  // Of each piece to which something happened: its number and how many numbers follow, in one, then these.
  using Entry = std::vector<std::int64_t>;
  struct Arrived {
    std::uint32_t period;
    Entry entry;
  };
  struct Peer {
    std::int64_t lacks = 0;      // the first boundary
    std::uint32_t heard_at = 0;  // the own boundary
  };
  std::vector<std::int64_t> told_from(std::int64_t first) const;

  Rule rule_ = Rule::alike;
  std::uint32_t boundary_ = 0, grew_at_ = 0;  // the own ones: the newest, and where something was applied last
  std::vector<std::string> pieces_;           // in the order in which they ask, which is the same in all labs
  // Of the lab that decides.
  Entry open_;
  std::vector<Entry> log_;  // by boundary
  std::map<std::string, Peer, std::less<>> peers_;
  std::size_t turn_ = 0;
  // Of others.
  std::uint64_t owners_run_ = 0;
  bool restarted_ = false;  // the owner, which has forgotten it
  std::int64_t lacks_ = 0;  // the first boundary that has not arrived
  std::vector<Arrived> arrived_, now_;
  hal::Counters counters_;
};

}  // namespace arkmesh::lab
