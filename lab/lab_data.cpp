#include "lab/lab_data.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

namespace arkmesh::lab {

LabData make_lab_data(const RunConfig& config, const hal::ArenaInfo& arena) {
  LabData data;
  data.name = config.lab;
  data.owner = config.owner;
  data.labs = config.labs;
  data.arena = facts_of(arena);
  data.projections = config.projections;
  data.period_length = config.period;
  data.seed = config.seed;
  data.sensors = config.sensors;
  data.plain_exchange = config.exchange.plain();
  return data;
}

void tell_merged(LabData& data, std::uint32_t period, const std::vector<MergedState>& merged) {
  data.period = period;
  data.now = data.period_length * period;
  data.drawn_before = !data.drawing.empty();
  data.drawing.clear();
  auto place = data.states.begin();  // both ascend by lab
  for (const MergedState& each : merged) {
    if (each.initial) data.initial_states.insert_or_assign(each.lab, each.initial);
    place = std::next(data.states.insert_or_assign(place, each.lab, each.state));
  }
}

void add_curves(LabData& data) {
  constexpr hal::LabTime each = std::chrono::seconds(1);
  constexpr std::string_view series = "series.";
  if (data.period == 0) {
    for (const Shown& shown : data.shown)
      if (std::string name = shown.curve && shown.of.starts_with(series) ? shown.of.substr(series.size()) : "";
          // one with a dot may be a table's column
          !name.empty() && (name.find('.') == name.npos || data.counts.all().contains(name)))
        data.curves.push_back(std::move(name));
  }
  const std::int64_t periods =
      std::max<std::int64_t>(1, (each + data.period_length - hal::LabTime{1}) / data.period_length);
  if (data.curves.empty() || data.period % periods != 0) return;
  std::string values = fmt::format("{:g}", std::chrono::duration<double>(data.now).count());
  for (const std::string& name : data.curves) values += fmt::format(",{}", data.counts[name]);
  data.rows.push_back({"curves", fmt::format("time_s,{}", fmt::join(data.curves, ",")), std::move(values)});
}

void write_rows(LabData& data, hal::Recorder& recorder) {
  for (const Row& row : data.rows) recorder.row(row.table, row.header, row.values);
  data.rows.clear();
}

void forget_sent(LabData& data) {
  data.commands.clear();
  data.parameters.clear();
  data.rows.clear();
}

}  // namespace arkmesh::lab
