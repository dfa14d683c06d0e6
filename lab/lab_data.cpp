#include "lab/lab_data.hpp"

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
