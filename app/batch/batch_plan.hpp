// What a batch runs: a grid of settings times seeds, as a list of independent runs whose numbers never change. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "app/lab_files.hpp"

namespace arkmesh::app {

// One axis of the grid: a key with values, or a choice between groups of overrides.
struct Factor {
  struct Level {
    std::string label;  // as tables show it
    std::vector<std::string> sets;
  };
  std::string name;
  std::vector<Level> levels;
};

// What a plot shows, by names of the table's columns.
struct BatchPlot {
  std::string column, over, by, kind;  // by and kind may be empty
  // Any of width, xlabel, ylabel and title, as drawing/figure_style.py takes them.
  std::map<std::string, std::string> looks;
};

// The first factor changes slowest, seeds change fastest: run = setting * seeds + number of the seed.
struct BatchPlan {
  LabFiles labs;  // with the overrides of all runs
  std::vector<Factor> factors;
  std::vector<std::int64_t> seeds;
  std::vector<BatchPlot> plots;
  std::map<std::string, std::string> places;  // where an override is written, for messages

  std::size_t settings() const;
  std::size_t runs() const { return settings() * seeds.size(); }
  std::size_t setting_of(std::size_t run) const { return run / seeds.size(); }
  std::int64_t seed_of(std::size_t run) const { return seeds[run % seeds.size()]; }
  // The level of each factor, by its number.
  std::vector<std::size_t> levels_of(std::size_t setting) const;
  // Labels in the order of factors.
  std::vector<std::string> labels_of(std::size_t setting) const;
  // "pair = Ro-Ro, gate.period_s = 2"; empty without factors.
  std::string name_of(std::size_t setting) const;
  LabFiles labs_of(std::size_t setting) const;
};

// "1..20", or the same with a step: "0..1 step 0.25". Every value as it is written in TOML; whole numbers stay so, and
// the last is included when the steps meet it. Throws std::invalid_argument with what is wrong.
std::vector<std::string> range_values(const std::string& text);
// Seeds of "1..20", or of whole numbers and such ranges. Throws std::invalid_argument when they are none, below 0, or
// one is there twice.
std::vector<std::int64_t> seeds_of(const std::vector<std::string>& parts);

// No batch has more.
inline constexpr std::size_t max_batch_runs = 1'000'000;

}  // namespace arkmesh::app
