#include "app/batch/batch_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "app/batch/batch_folder.hpp"
#include "app/batch/statistics.hpp"
#include "hal/replace_file.hpp"

namespace arkmesh::app {
namespace {

// Six digits tell more than any sample of ours; a NaN is an empty cell.
std::string shown(double number) {
  return std::isnan(number) ? "" : fmt::format("{:.6g}", number);
}

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
  // of what is alike everywhere there is nothing to tell, but of counts that is news, too
  const std::vector<std::string> counts = columns_of(rows_, true);
  for (const std::string& column : columns_) {
    // what a lab counted bears its name
    const bool is_result = std::ranges::find(counts, column) != counts.end() || column.find('.') == column.npos;
    (is_result ? results_ : counters_).push_back(column);
    std::set<std::string> values;
    for (const BatchRow& row : rows_)
      if (is_finished(row)) values.insert(cell(row, column));
    if (values.size() > 1 || std::ranges::find(counts, column) != counts.end()) told_.push_back(column);
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

std::vector<std::vector<double>> BatchResults::by_setting(const std::string& column) const {
  std::vector<std::vector<double>> out(plan_.settings());
  for (const BatchRow& row : rows_) {
    const std::string text = is_finished(row) ? cell(row, column) : "";
    if (const double number = std::strtod(text.c_str(), nullptr); !text.empty() && std::isfinite(number))
      out[plan_.setting_of(row.run)].push_back(number);
  }
  return out;
}

std::string BatchResults::summary() const {
  std::string out = "setting" + factor_names() + ",column,n,mean,sd,se,low95,high95,min,median,max\n";
  for (const std::string& column : told_) {
    const std::vector<std::vector<double>> samples = by_setting(column);
    for (std::size_t setting = 0; setting < samples.size(); ++setting) {
      if (samples[setting].empty()) continue;
      const SampleSummary s = summarize(samples[setting]);
      out += fmt::format("{}{},{},{},{},{},{},{},{},{},{},{}\n", setting, label_cells(setting), csv_text(column), s.n,
                         shown(s.mean), shown(s.sd), shown(s.se), shown(s.low95), shown(s.high95), shown(s.min),
                         shown(s.median), shown(s.max));
    }
  }
  return out;
}

// Of each two settings that differ in one factor only.
void BatchResults::add_effects(std::string& out, const std::string& column) const {
  const std::vector<std::vector<double>> samples = by_setting(column);
  for (std::size_t from = 0; from < samples.size(); ++from) {
    std::size_t stride = 1;
    for (std::size_t f = plan_.factors.size(); f-- > 0; stride *= plan_.factors[f].levels.size()) {
      const std::size_t level = plan_.levels_of(from)[f];
      for (std::size_t other = level + 1; other < plan_.factors[f].levels.size(); ++other) {
        const std::size_t to = from + (other - level) * stride;
        if (samples[from].empty() || samples[to].empty()) continue;
        const SampleDifference d = compare(samples[from], samples[to]);
        out +=
            fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_text(column), csv_text(plan_.factors[f].name),
                        csv_text(plan_.factors[f].levels[level].label), csv_text(plan_.factors[f].levels[other].label),
                        from, to, samples[from].size(), samples[to].size(), shown(d.difference), shown(d.low95),
                        shown(d.high95), shown(d.hedges_g), shown(d.cliffs_delta));
      }
    }
  }
}

std::string BatchResults::effects() const {
  std::string out =
      "column,factor,from,to,setting_from,setting_to,n_from,n_to,difference,low95,high95,hedges_g,cliffs_delta\n";
  for (const std::string& column : told_) add_effects(out, column);
  return out;
}

void BatchResults::save() const {
  hal::must_replace_file(directory_ / "runs.csv", runs());
  hal::must_replace_file(directory_ / "counters.csv", counters());
  hal::must_replace_file(directory_ / "summary.csv", summary());
  hal::must_replace_file(directory_ / "effects.csv", effects());
}

}  // namespace arkmesh::app
