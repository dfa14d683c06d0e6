// What a scenario sees of its lab. No bus, socket or wall clock is within reach, so no scenario can work only in
// simulation.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "hal/arena.hpp"
#include "hal/counters.hpp"
#include "hal/random.hpp"
#include "hal/types.hpp"
#include "lab/lab_state.hpp"
#include "lab/projection.hpp"

namespace arkmesh::lab {

class Lab {
 public:
  // --- who and where ---
  const std::string& name() const { return name_; }
  const std::vector<std::string>& labs() const {
    return labs_;
  }                                                    // all labs of the shared world, ascending, own included
  const std::string& owner() const { return owner_; }  // the lab that decides the shared things
  bool is_owner() const { return name_ == owner_; }
  const hal::ArenaInfo& arena() const { return *arena_; }
  const Projection& projection() const { return projections_.find(name_)->second; }
  const Projection& projection(std::string_view lab) const { return projections_.find(lab)->second; }

  // --- time ---
  hal::LabTime now() const { return now_; }         // stamp of the frame, or time of the boundary
  std::uint32_t period() const { return period_; }  // boundaries passed; 0 during begin() and period 0's on_period
  hal::LabTime period_length() const { return period_length_; }

  // --- the shared environment ---
  // Declares a field, in begin(), alike in all labs. Undeclared or ill-formed fields of peers are refused and counted.
  void declare(FieldRule rule) { rules_.push_back(std::move(rule)); }
  // Sets an own field; it is part of every own state from the next boundary on (state 0: what begin() set).
  void publish(std::string_view field, std::vector<std::int64_t> values) {
    fields_.insert_or_assign(std::string(field), std::move(values));
  }
  // The merged state of a lab (own lab included) that is in force since the last boundary. Not before on_period of
  // period 0.
  const LabState& state(std::string_view lab) const { return states_.find(lab)->second; }
  // A field in state(lab); empty when that state does not hold it.
  const std::vector<std::int64_t>& field(std::string_view lab, std::string_view field) const;
  // As `field`, but of that lab's state 0, which stays at hand for the whole run.
  const std::vector<std::int64_t>& initial_field(std::string_view lab, std::string_view field) const;

  // --- acting ---
  // Tells a robot something; goes out after on_poses or on_period returns. Newest per (robot, slot) wins.
  void say(const hal::ToRobot& message) { said_.push_back(message); }
  void command(const hal::FleetCommand& command) { commands_.push_back(command); }
  // The stream "<lab>/<purpose>"; the reference stays good.
  hal::RandomStream& random(std::string_view purpose);

  // --- telling people ---
  // A row of `table`.csv in the run folder; `header` is the comma-separated first line.
  void row(std::string_view table, std::string_view header, std::string_view values) {
    if (rows_) rows_(table, header, values);
  }
  // Something virtual to draw on the table until the next boundary; called in on_period.
  void mark(hal::Mark mark) { marks_.push_back(std::move(mark)); }
  // A total of the result (result.json "counts") and of the status message.
  hal::Counters& counts() { return counts_; }
  const hal::Counters& counts() const { return counts_; }

 private:
  friend class LabRun;
  friend struct LabDouble;  // tests of scenarios without a lab
  std::string name_, owner_;
  std::vector<std::string> labs_;
  const hal::ArenaInfo* arena_ = nullptr;
  std::map<std::string, Projection, std::less<>> projections_;
  hal::LabTime now_{0}, period_length_{0};
  std::uint32_t period_ = 0;
  std::uint64_t seed_ = 0;
  std::vector<FieldRule> rules_;
  std::map<std::string, std::vector<std::int64_t>, std::less<>> fields_;
  std::map<std::string, LabState, std::less<>> states_, initial_states_;
  std::map<std::string, hal::RandomStream, std::less<>> streams_;
  std::vector<hal::ToRobot> said_;
  std::vector<hal::FleetCommand> commands_;
  std::vector<hal::Mark> marks_;
  std::function<void(std::string_view, std::string_view, std::string_view)> rows_;
  hal::Counters counts_;
};

}  // namespace arkmesh::lab
