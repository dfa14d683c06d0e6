// What is behind the facade that a scenario sees: what its runner tells it, and what it asked of its runner. The runner
// owns it and reads and writes it freely; a scenario reaches it through Lab only.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "hal/arenas/projection.hpp"
#include "hal/counters.hpp"
#include "hal/overlay/drawing.hpp"
#include "hal/random.hpp"
#include "hal/record/recorder.hpp"
#include "hal/types.hpp"
#include "lab/arena_facts.hpp"
#include "lab/exchange/growth.hpp"
#include "lab/exchange/lab_state.hpp"
#include "lab/exchange/state_rules.hpp"
#include "lab/robots/robot_words.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::lab {

// A row of TABLE.csv in the run folder.
struct Row {
  std::string table, header, values;
};

// What people are told of something that they see, as in shown_words_t.
struct Shown {
  std::string of, words, unit;
  bool curve = false;
};

struct LabData {
  // --- constant for the run ---
  std::string name, owner;
  std::vector<std::string> labs;  // ascending, own included
  ArenaFacts arena;
  std::map<std::string, hal::Projection, std::less<>> projections;  // one for each lab
  hal::LabTime period_length{0};
  std::uint64_t seed = 0;
  SensorConfig sensors;
  bool plain_exchange = true;

  // --- what the runner tells ---
  hal::LabTime now{0};
  std::uint32_t period = 0;
  bool declaring = true;                                                 // until begin() has returned
  std::map<std::string, KeptState, std::less<>> states, initial_states;  // as merged; empty before the first merge

  // --- what the scenario says ---
  std::vector<FieldRule> rules;
  std::map<std::string, std::vector<std::int64_t>, std::less<>> fields;
  std::map<std::string, hal::RandomStream, std::less<>> streams;
  std::vector<hal::ToRobot> to_robots;
  Growth growth;     // what of it is told to other labs
  RobotWords words;  // of which RobotBook is told what robots may have forgotten
  std::vector<hal::FleetCommand> commands;
  std::vector<hal::WholeMessage> parameters;
  hal::Drawing drawing;       // since the last boundary
  bool drawn_before = false;  // at the boundary before that
  std::vector<Row> rows;
  std::map<std::string, std::string, std::less<>> headers;  // of tables, by their first row
  hal::Counters counts;
  std::set<std::string, std::less<>> shared_totals;  // those of `counts` that all labs tell alike
  std::vector<Shown> shown;
  std::vector<std::string> curves;  // counts that curves.csv has, from boundary 0 on
};

// As it is before begin().
LabData make_lab_data(const RunConfig& config, const hal::ArenaInfo& arena);
// The states merged at boundary `period` are in force.
void tell_merged(LabData& data, std::uint32_t period, const std::vector<MergedState>& merged);
// A row of curves.csv, once in a second of lab time or, where that is longer, at each boundary: the counts that the
// scenario shows as curves.
void add_curves(LabData& data);
// The rows that the scenario said, to their tables.
void write_rows(LabData& data, hal::Recorder& recorder);
// What the scenario said has gone out.
void forget_sent(LabData& data);

}  // namespace arkmesh::lab
