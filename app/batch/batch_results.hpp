// The tables of a batch: runs.csv, counters.csv, summary.csv and effects.csv, docs/formats.md.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "app/batch/batch_plan.hpp"
#include "app/batch/batch_table.hpp"

namespace arkmesh::app {

class BatchResults {
 public:
  // Reads the results of the runs in a batch's folder. Throws ConfigError when they count what a factor is called.
  BatchResults(const BatchPlan& plan, const std::filesystem::path& directory);

  // A row for each run that has ended.
  const std::vector<BatchRow>& rows() const { return rows_; }
  std::size_t finished() const;
  // Throws ConfigError for a plot of a column that no run has had. What is measured may come with a later one.
  void check_plots() const;
  // Writes the first two tables, and has drawing/summarise_batch write the others. Throws std::runtime_error when the
  // disk is full.
  void save() const;

 private:
  // A row for each run: which it is, the cells below `head`, and its numbers of these columns.
  std::string table(const std::string& head, const std::vector<std::string>& columns,
                    const std::function<std::string(const BatchRow&)>& cells) const;
  std::string runs() const;
  std::string counters() const;
  std::string label_cells(std::size_t setting) const;
  std::string factor_names() const;

  const BatchPlan& plan_;
  std::filesystem::path directory_;
  std::vector<BatchRow> rows_;
  std::vector<std::string> columns_;             // of any table
  std::vector<std::string> results_, counters_;  // those of the two tables of runs
};

}  // namespace arkmesh::app
