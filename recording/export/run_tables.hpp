// A run as tables: those of the messages of every channel of every lab, and the tables that labs and scenarios have
// written themselves.
#pragma once

#include <string>
#include <vector>

#include "recording/export/tables.hpp"
#include "recording/export/watch.hpp"
#include "recording/run.hpp"

namespace arkmesh::recording {

// What an export leaves out, and why: one sentence each.
using Notes = std::vector<std::string>;

// The labs' names, safe and each once.
std::vector<std::string> groups_of(const Run& run);

// Only tables with texts, when only their lengths are wanted.
enum class Which { all, with_texts };
// Throws Stopped, and what the sink throws.
Notes write_tables(const Run& run, TableSink& sink, Watch& watch, Which which = Which::all);

}  // namespace arkmesh::recording
