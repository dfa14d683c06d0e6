// What happened in a recorded run: events, and counts over time, from its messages and tables.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "recording/run.hpp"

namespace arkmesh::recording {

struct StoryEvent {
  std::int64_t t_us = 0;
  std::string kind;  // "command", "state", "link", or the name of a table
  std::string text;
};

// In the order of time: commands to robots and of operators, changes of the lab's state and of its links, and rows of
// tables with a time_s that are not written at even times, such as DHTF's completed.csv. At most 5000; a last one says
// so.
std::vector<StoryEvent> events_of(const RecordedLab& lab);

struct Series {
  std::string name;  // "completed", "swarms.north"
  std::vector<double> t_s, y;
};

// Of a table with rows at even times each column of numbers; of another one with time_s how many rows there were; and
// what the scenario has counted.
std::vector<Series> series_of(const RecordedLab& lab);

struct Difference {
  std::int64_t period = 0;
  std::string lab;
  std::int64_t t_us = 0;  // of the period's end
};

// The first period in which a lab of both runs has another hash in its hash.csv; nothing: there is none. `compared`:
// how many periods of how many labs both have.
struct Comparison {
  std::optional<Difference> first;
  std::size_t labs = 0, periods = 0;
  std::string in_words() const;
};
Comparison compare(const Run& a, const Run& b);

}  // namespace arkmesh::recording
