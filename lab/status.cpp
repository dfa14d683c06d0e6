#include "lab/status.hpp"

#include <utility>

#include "hal/messages.hpp"

namespace arkmesh::lab {

lab_status_t to_message(const Status& status) {
  lab_status_t m;
  m.lab = status.lab;
  m.nonce = static_cast<std::int64_t>(status.run_id);
  m.state = status.state;
  m.stamp_us = status.stamp.count();
  m.period = static_cast<std::int32_t>(status.period);
  m.last_period = static_cast<std::int32_t>(status.last_period);
  const double wall_s = static_cast<double>(status.moving.count()) * 1e-6;
  m.speed = wall_s > 0 ? static_cast<double>(m.stamp_us) * 1e-6 / wall_s : 0;
  m.can_wait = status.can_wait;
  m.counters = hal::to_message(status.drops);
  for (counter_t& c : hal::to_message(status.counts)) {
    c.name.insert(0, "counts.");
    m.counters.push_back(std::move(c));
  }
  m.n_counters = static_cast<std::int32_t>(m.counters.size());
  return m;
}

}  // namespace arkmesh::lab
