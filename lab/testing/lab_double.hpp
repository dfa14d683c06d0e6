// Labs of one shared world without buses, gateways or arenas: what a scenario publishes is checked against its declared
// rules and merged at each boundary, in all labs at once. For unit tests of scenarios, with any test framework: what a
// scenario must not publish throws std::logic_error.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "lab/scenario.hpp"

namespace arkmesh::lab {

struct LabDouble {
  LabData data;
  Lab lab{data};
  std::unique_ptr<Scenario> scenario;
  std::vector<hal::ToRobot> said;   // since the test last cleared it
  std::vector<SharedRobot> robots;  // as in the newest frame

  LabDouble() = default;
  LabDouble(const LabDouble&) = delete;

  void set_up(const std::string& name, const std::vector<std::string>& labs, const std::string& owner,
              std::uint64_t seed, hal::LabTime period_length,
              const std::map<std::string, hal::Projection, std::less<>>& projections) {
    data.name = name;
    data.labs = labs;
    data.owner = owner;
    data.projections = projections;
    data.period_length = period_length;
    data.seed = seed;
  }

  const std::vector<Row>& rows() const { return data.rows; }
  const hal::Drawing& drawing() const { return data.drawing; }

  void take_said() {
    said.insert(said.end(), data.to_robots.begin(), data.to_robots.end());
    data.to_robots.clear();
  }

  void frame(const hal::PoseFrame& frame) {
    data.now = frame.stamp;
    robots.clear();
    for (const hal::Observation& s : frame.robots)
      robots.push_back({s.robot, lab.projection().to_shared(s.pose), s.led});
    scenario->on_poses(lab, frame);
    take_said();
  }

  // The state that this lab publishes at a boundary.
  LabState build(std::uint32_t period) {
    LabState state{.period = period, .robots = robots, .fields = data.fields};
    for (const auto& [name, values] : state.fields) check(name, values);
    if (period == 0)
      for (const FieldRule& rule : data.rules)
        if (rule.initial_only) data.fields.erase(rule.name);
    return state;
  }

  void merge(std::uint32_t period, const std::map<std::string, LabState, std::less<>>& states) {
    data.period = period;
    data.now = period * data.period_length;
    for (const auto& [name, state] : states) {
      data.states[name] = std::make_shared<const LabState>(state);
      if (period == 0) data.initial_states[name] = data.states[name];
    }
    data.drawing.clear();
    scenario->on_period(lab);
    take_said();
  }

 private:
  void check(const std::string& name, const std::vector<std::int64_t>& values) const {
    const auto rule = std::ranges::find(data.rules, name, &FieldRule::name);
    const auto expect = [&](bool good, const char* wrong) {
      if (!good) throw std::logic_error(fmt::format("lab {}, field {}: {}", lab.name(), name, wrong));
    };
    expect(rule != data.rules.end(), "is published, and not declared");
    expect(rule->up_to ? values.size() <= rule->length : values.size() == rule->length,
           "has another number of values than it declares");
    for (const std::int64_t v : values) expect(rule->low <= v && v <= rule->high, "has a value outside its bounds");
    expect(!rule->owner_only || lab.is_owner(), "is published by a lab that is not the owner");
  }
};

class WorldDouble {
 public:
  // Labs in ascending order of their names; the arenas are `side_m` squares.
  struct Member {
    std::string name;
    double side_m = 1;
    hal::Projection projection{};
  };
  WorldDouble(const std::vector<Member>& members, const std::string& owner, std::uint64_t seed = 1,
              std::uint32_t slack = 0, hal::LabTime period_length = hal::LabTime(2'000'000))
      : slack_(slack), period_length_(period_length), labs_(members.size()) {
    std::vector<std::string> names;
    std::map<std::string, hal::Projection, std::less<>> projections;
    for (const Member& m : members) {
      names.push_back(m.name);
      projections[m.name] = m.projection;
    }
    for (std::size_t i = 0; i < members.size(); ++i) {
      labs_[i].data.arena.width_m = labs_[i].data.arena.height_m = members[i].side_m;
      labs_[i].set_up(names[i], names, owner, seed, period_length, projections);
    }
  }

  LabDouble& operator[](std::string_view name) {
    for (LabDouble& lab : labs_)
      if (lab.lab.name() == name) return lab;
    throw std::invalid_argument("no such lab");
  }
  std::deque<LabDouble>& labs() { return labs_; }
  const std::vector<std::string>& names() const { return labs_.front().lab.labs(); }

  // Gives every lab its scenario and begins; then boundary 0.
  void begin(const std::function<std::unique_ptr<Scenario>(const std::string& lab)>& make) {
    for (LabDouble& lab : labs_) {
      lab.scenario = make(lab.lab.name());
      lab.scenario->begin(lab.lab);
    }
    boundary();
  }

  // The next boundary in all labs. Labs named in `silent` are not heard: their last merged state stays in force.
  void boundary(const std::vector<std::string>& silent = {}) {
    const std::uint32_t period = next_period_++;
    for (LabDouble& lab : labs_) history_[lab.lab.name()].push_back(lab.build(period));
    for (auto& [name, states] : history_) {
      if (std::find(silent.begin(), silent.end(), name) != silent.end()) continue;
      merged_.insert_or_assign(name, states[period > slack_ ? period - slack_ : 0]);
    }
    for (LabDouble& lab : labs_) lab.merge(period, merged_);
  }

  // Lab time of the newest boundary.
  hal::LabTime now() const { return (next_period_ - 1) * period_length_; }

 private:
  std::uint32_t slack_, next_period_ = 0;
  hal::LabTime period_length_;
  std::deque<LabDouble> labs_;
  std::map<std::string, std::vector<LabState>> history_;
  std::map<std::string, LabState, std::less<>> merged_;
};

}  // namespace arkmesh::lab
