// What a scenario sees of its lab. No bus, socket or wall clock is within reach, and nothing tells a simulated arena
// from a real one, so no scenario can work only in simulation.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/arenas/projection.hpp"
#include "hal/counters.hpp"
#include "hal/overlay/drawing.hpp"
#include "hal/random.hpp"
#include "hal/robot/set_point.hpp"
#include "hal/types.hpp"
#include "lab/arena_facts.hpp"
#include "lab/exchange/lab_state.hpp"
#include "lab/lab_data.hpp"

namespace arkmesh::lab {

class Lab {
 public:
  // `data` is the runner's and outlives the facade.
  explicit Lab(LabData& data) : data_(data) {}

  // --- who and where ---
  const std::string& name() const { return data_.name; }
  // All labs of the shared world, ascending, own included.
  const std::vector<std::string>& labs() const { return data_.labs; }
  // The lab that decides the shared things.
  const std::string& owner() const { return data_.owner; }
  bool is_owner() const { return data_.name == data_.owner; }
  const ArenaFacts& arena() const { return data_.arena; }
  const hal::Projection& projection() const { return projection(data_.name); }
  // Throws std::out_of_range with one sentence for a lab that there is not.
  const hal::Projection& projection(std::string_view lab) const;

  // How robots here sense those of other labs; labs may differ in it.
  const SensorConfig& sensors() const { return data_.sensors; }
  std::uint64_t seed() const { return data_.seed; }  // run.seed, one for all labs

  // Whether each state of each lab carries all that the lab has published (gate.exchange).
  bool tells_all_each_period() const { return data_.plain_exchange; }

  // --- time ---
  hal::LabTime now() const { return data_.now; }         // of the frame, of what robots said, or of the boundary
  std::uint32_t period() const { return data_.period; }  // boundaries passed; 0 in begin() and period 0's on_period
  hal::LabTime period_length() const { return data_.period_length; }

  // --- the shared environment ---
  // Declares a field, alike in all labs. Undeclared or ill-formed fields of peers are refused and counted. In begin()
  // only: std::logic_error later.
  void declare(FieldRule rule);
  // Sets an own field; it is part of every own state from the next boundary on (state 0: what begin() set).
  void publish(std::string_view field, std::vector<std::int64_t> values) {
    data_.fields.insert_or_assign(std::string(field), std::move(values));
  }
  // The merged state of a lab (own lab included) that is in force since the last boundary. Throws std::logic_error
  // before on_period of period 0, and std::out_of_range for a lab that there is not, with one sentence each.
  const LabState& state(std::string_view lab) const { return merged(data_.states, lab); }
  // A field in state(lab); empty when that state does not hold it. Throws as state() does.
  const std::vector<std::int64_t>& field(std::string_view lab, std::string_view field) const;
  // As `field`, but of that lab's state 0, which stays at hand for the whole run. A lab that was restarted has another
  // one, from the boundary on that first merges its new run.
  const std::vector<std::int64_t>& initial_field(std::string_view lab, std::string_view field) const;
  // For what grows over boundaries, such as a stock or a trail: called once in each on_period, from that of period 0 on
  // and in the same order in all labs, with what by the merged states happened to it in the last period; nothing when
  // that is nothing. Returns what to apply, in order, each for one period (of period 0, for none): `happened` itself,
  // or, where labs do not wait for each other, what the owner's lab had, so that all labs hold the same. That may be
  // nothing for now, several periods at once, and, from a lab of others, anything.
  std::vector<Grown> grow(std::string_view name, std::vector<std::int64_t> happened) {
    return data_.growth.pass(name, data_.period, std::move(happened));
  }

  // --- acting ---
  // Says something to a robot, once; goes out after on_poses, on_heard or on_period returns, the first time at the
  // first boundary. Newest per (robot, slot) wins.
  void say(const hal::ToRobot& message) { data_.to_robots.push_back(message); }
  // Says `word` when it has changed and, called for each frame, every `again` until the robot shows it. The lab keeps
  // it, and says it anew by itself when the robot may have missed or forgotten it: after a reset, out of sight or
  // switched off, when the line was away. `shown`: whether it shows that it knows, or need not be told again; or what
  // its LED shows, which is then another than when the word changed (RobotWords).
  void tell(const hal::ToRobot& word, bool shown, hal::LabTime again = std::chrono::seconds(1)) {
    if (data_.words.due(data_.now, word, shown, again)) say(word);
  }
  void tell(const hal::ToRobot& word, hal::Led led, hal::LabTime again = std::chrono::seconds(1)) {
    if (data_.words.due(data_.now, word, led, again)) say(word);
  }
  // Speeds of a robot's wheels, said when they change and kept as tell() keeps words. Throws std::invalid_argument with
  // one sentence where robots cannot be driven (ArenaFacts::can_be_driven).
  void drive(hal::RobotId robot, const hal::SetPoint& wheels);
  void command(const hal::FleetCommand& command) { data_.commands.push_back(command); }
  // What robots have to know before they run: the lab repeats it to all of them right before they begin, before they
  // run after a reset, and when some may lack it. Those of a type from one call of the scenario replace former
  // ones (RobotBook::prepare). What comes while they run is said before their next run, or with that.
  void parameters(const hal::WholeMessage& message) { data_.parameters.push_back(message); }
  // The stream "<lab>/<purpose>"; the reference stays good.
  hal::RandomStream& random(std::string_view purpose);
  // The stream "/<purpose>", which has the same numbers in all labs, for those that draw alike; the reference stays
  // good.
  hal::RandomStream& common_random(std::string_view purpose);

  // --- telling people ---
  // A row of `table`.csv in the run folder; `header` is the comma-separated first line, the same for all rows. Throws
  // std::invalid_argument for another one, for a row with more or fewer values, for a table of the lab's own, and for a
  // name above 100 bytes or with a '/', which no file may have.
  void row(std::string_view table, std::string_view header, std::string_view values);
  // Something virtual that people see in this arena until the next boundary; called in on_period. Robots see nothing of
  // it, and no result depends on it. A shape that cannot be drawn is left out and counted, as
  // "overlay.refused.<reason>" (hal::Drawing).
  void draw(hal::Circle shape) { drawn(data_.drawing.add(std::move(shape))); }
  void draw(hal::Polygon shape) { drawn(data_.drawing.add(std::move(shape))); }
  void draw(hal::Line shape) { drawn(data_.drawing.add(std::move(shape))); }
  void draw(hal::Text shape) { drawn(data_.drawing.add(std::move(shape))); }
  void draw(hal::Raster shape) { drawn(data_.drawing.add(std::move(shape))); }
  // What people are told of something that they see, in begin() only. `of`: "series.NAME" of a count or of
  // TABLE.COLUMN, which is drawn as a curve where `curve` says so, "colour.NAME" of what is drawn and "led.N", which
  // are explained by their words, or "setting.KEY". Throws std::invalid_argument for others, and for words longer than
  // labels.
  void show(Shown about);
  // A total of the shared world, which all labs tell alike: a run's result has it once.
  void total(std::string_view name, std::uint64_t n) {
    data_.counts.set(name, n);
    data_.shared_totals.emplace(name);
  }
  // Totals of this lab, in its result.json as "counts" and in its status message; a run's result sums those of all
  // labs.
  hal::Counters& counts() { return data_.counts; }
  const hal::Counters& counts() const { return data_.counts; }
  const std::set<std::string, std::less<>>& shared_totals() const { return data_.shared_totals; }
  const std::vector<Shown>& shown() const { return data_.shown; }

 private:
  using States = std::map<std::string, KeptState, std::less<>>;
  const LabState& merged(const States& states, std::string_view lab) const;
  hal::RandomStream& stream(std::string_view key, std::string_view lab, std::string_view purpose);
  void drawn(std::string_view refused) {
    if (!refused.empty()) data_.counts.add("overlay.refused." + std::string(refused));
  }

  LabData& data_;
};

}  // namespace arkmesh::lab
