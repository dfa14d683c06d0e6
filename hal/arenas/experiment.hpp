// shared.experiment: what tells the gateways of one experiment from those of another.
#pragma once

#include <fmt/format.h>

#include <string>

#include "hal/config/config.hpp"
#include "hal/label.hpp"

namespace arkmesh::hal {

struct Experiment {
  std::string id;  // at first what it is by default, the scenario's name; may be empty then

  void fields(const Section& shared) {
    const std::string by_default = id;
    shared.field(
        "experiment", id,
        {.help = "name of the experiment; gateways join only labs with the same one; at most 63 printable characters",
         .default_is = "run.scenario"});
    if (id != by_default && !is_label(id))
      shared.refuse("experiment", fmt::format("must be 1 to {} printable characters", max_label));
  }
};

}  // namespace arkmesh::hal
