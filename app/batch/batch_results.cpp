#include "app/batch/batch_results.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "app/batch/batch_folder.hpp"
#include "hal/config/config.hpp"
#include "hal/config/near_key.hpp"
#include "hal/files/own_files.hpp"
#include "hal/files/replace_file.hpp"

namespace arkmesh::app {
namespace {

bool is_finished(const BatchRow& row) {
  return row.state == RunState::finished;
}

}  // namespace

BatchResults::BatchResults(const BatchPlan& plan, const std::filesystem::path& directory)
    : plan_(plan), directory_(directory) {
  for (std::size_t run = 0; run < plan.runs(); ++run) {
    BatchRow row{.run = run, .seed = plan.seed_of(run)};
    if (read_row(BatchFolder::run_folder(directory, run), row) && row.state != RunState::missing)
      rows_.push_back(std::move(row));
  }
  columns_ = columns_of(rows_, false);
  for (const Factor& factor : plan.factors)
    if (std::ranges::find(columns_, factor.name) != columns_.end())
      throw hal::ConfigError(fmt::format("{0} is the name of both a count and a factor; rename one", factor.name));
  const std::vector<std::string> counts = columns_of(rows_, true);
  for (const std::string& column : columns_) {
    // what a lab counted bears its name
    const bool is_result = std::ranges::find(counts, column) != counts.end() || column.find('.') == column.npos;
    (is_result ? results_ : counters_).push_back(column);
  }
}

void BatchResults::check_plots() const {
  std::set<std::string, std::less<>> known(columns_.begin(), columns_.end());
  known.insert({"run", "setting", "seed"});
  for (const Factor& factor : plan_.factors) known.insert(factor.name);
  for (const BatchPlot& plot : plan_.plots) {
    if (known.contains(plot.column) || is_measured(plot.column)) continue;
    const auto near = hal::near_key(plot.column, known);
    throw hal::ConfigError(fmt::format(
        "[[plot]] column = \"{}\": no run so far has this column{}; if the count may stay 0, count 0 at the beginning",
        plot.column,
        near ? fmt::format("; did you mean {}?", *near) : fmt::format("; there are {}", fmt::join(results_, ", "))));
  }
}

std::size_t BatchResults::finished() const {
  return static_cast<std::size_t>(std::ranges::count_if(rows_, is_finished));
}

std::string BatchResults::factor_names() const {
  std::string out;
  for (const Factor& factor : plan_.factors) out += "," + csv_text(factor.name);
  return out;
}

std::string BatchResults::label_cells(std::size_t setting) const {
  std::string out;
  for (const std::string& label : plan_.labels_of(setting)) out += "," + csv_text(label);
  return out;
}

std::string BatchResults::table(const std::string& head, const std::vector<std::string>& columns,
                                const std::function<std::string(const BatchRow&)>& cells) const {
  std::string out = "run,setting" + factor_names() + ",seed" + head;
  for (const std::string& column : columns) out += "," + csv_text(column);
  out += "\n";
  for (const BatchRow& row : rows_) {
    const std::size_t setting = plan_.setting_of(row.run);
    out += fmt::format("{},{}{},{}{}", row.run, setting, label_cells(setting), row.seed, cells(row));
    for (const std::string& column : columns) out += "," + cell(row, column);
    out += "\n";
  }
  return out;
}

std::string BatchResults::runs() const {
  return table(",state,why,final_hash", results_, [](const BatchRow& row) {
    return fmt::format(",{},{},{}", is_finished(row) ? "finished" : "failed", is_finished(row) ? "" : csv_text(row.why),
                       row.final_hash);
  });
}

std::string BatchResults::counters() const {
  return table("", counters_, [](const BatchRow&) { return std::string(); });
}

void BatchResults::save() const {
  hal::must_replace_file(directory_ / "runs.csv", runs());
  hal::must_replace_file(directory_ / "counters.csv", counters());
  hal::run_script("summarise_batch", {directory_.string()});
}

}  // namespace arkmesh::app
