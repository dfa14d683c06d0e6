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
  return data;
}

}  // namespace arkmesh::lab
