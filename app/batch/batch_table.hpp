// The results of a batch as one table, from the result.json of each run: a row for each run that has ended, a column
// for each number. Nothing of wall time is in it, so equal batches give equal tables.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "app/batch/run_pool.hpp"

namespace arkmesh::app {

// A run as the table shows it.
struct BatchRow {
  std::size_t run = 0;
  std::int64_t seed = 0;
  RunState state = RunState::missing;
  std::string why;         // it ended: "finished", or the reason
  std::string final_hash;  // empty when it did not come that far
  // By column, as it is written: `periods`, `duration_s`, the names of counts, `<lab>.` and the name of a counter, and
  // `<lab>.between.<peer>.` and what is counted of that link.
  std::map<std::string, std::string> counts, numbers;
};

// False when there is no result of a run that has ended, in whatever way.
bool read_row(const std::filesystem::path& directory, BatchRow& row);
// Columns of any row; `counts` alone, or with all other numbers behind them.
std::vector<std::string> columns_of(const std::vector<BatchRow>& rows, bool counts_only);
// Whether a name ends in a unit, as "consensus.ms" and "consensus.ms@shark" do: what was not measured is not 0.
bool is_measured(std::string_view column);
// What stands in a column: 0 where others count what this run did not; nothing where it did not measure what others
// did, whose name ends in a unit ("consensus.ms"), and for a run that said nothing at all.
std::string cell(const BatchRow& row, const std::string& column);

// One field of a CSV row; what separates fields may be in it.
std::string csv_text(const std::string& text);

}  // namespace arkmesh::app
