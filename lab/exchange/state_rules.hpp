// What a peer's state can be: every field as the scenario declared it, every robot within its lab's arena. A value, and
// pure, so that lies are refused before they do harm.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/arenas/projection.hpp"
#include "lab/exchange/lab_state.hpp"

namespace arkmesh::lab {

// A field that a scenario publishes.
struct FieldRule {
  std::string name;
  std::size_t length = 0;  // number of values
  std::int64_t low = 0;    // every value within low..high
  std::int64_t high = 0;
  bool owner_only = false;    // only the owner of the shared things may publish it
  bool initial_only = false;  // part of state 0 only
  bool bookkeeping = false;   // tells nothing of robots and sites: neither part of the hash nor an event
  bool up_to = false;         // there may be fewer values
};

// The field of state 0 that tells others of a lab's arena and bounds what its robots can claim:
// [width_um, height_um, robots, largest id].
FieldRule arena_rule();
std::vector<std::int64_t> arena_values(const hal::ArenaInfo& arena);

// The field of state 0 of a lab that does not know all of what a state tells: a 1 for each thing that its states do not
// tell, in the order of Unknown. A lab without it knows everything.
enum class Unknown : std::uint8_t { poses, headings, ids, counts, settings, periods };
FieldRule unknown_rule();
std::vector<std::int64_t> unknown_values(std::initializer_list<Unknown> unknown);

// The owner's, where exchange is mixed: per lab in the order of names, the boundary at which the payload was made that
// the owner merged last. A lab sees by it that its events came through.
FieldRule applied_rule(std::size_t labs);

// Why a state cannot be true.
struct Refusal {
  std::string_view why;  // one word, fit for a counter's name
  std::string sentence;  // what is wrong, for people: "field 'team' holds 6, which is not within 0 to 5"
};

class StateRules {
 public:
  // `owner`: the lab that decides the shared things. `projections`: one for each lab.
  StateRules(std::string owner, std::vector<FieldRule> fields,
             std::map<std::string, hal::Projection, std::less<>> projections);

  // Why `state` of `lab` cannot be true, given its state 0; none when it can.
  std::optional<Refusal> refusal(std::string_view lab, const LabState& state, const LabState& initial) const;
  // Why a restarted lab cannot go on in the place of its former run: what it decides once is not what it was. Scenarios
  // read that once. `now`: a state 0 that refusal() takes.
  std::optional<Refusal> world_refusal(const LabState& before, const LabState& now) const;
  const std::vector<FieldRule>& fields() const { return fields_; }

 private:
  std::optional<Refusal> field_refusal(std::string_view lab, const LabState& state) const;

  std::string owner_;
  std::vector<FieldRule> fields_;
  std::map<std::string, hal::Projection, std::less<>> projections_;
};

}  // namespace arkmesh::lab
