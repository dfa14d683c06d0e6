#include "lab/status.hpp"

#include <utility>

#include "hal/messages.hpp"
#include "lab/runner.hpp"

namespace arkmesh::lab {

lab_status_t status_of(const Runner& run) {
  lab_status_t m;
  m.lab = run.config().lab;
  m.nonce = static_cast<std::int64_t>(run.run_id());
  m.state = run.state_text() + (run.armed() ? ", armed" : "");
  m.stamp_us = run.arena().clock().now().count();
  m.period = static_cast<std::int32_t>(run.period());
  m.last_period = static_cast<std::int32_t>(run.last_period());
  const double wall_s = static_cast<double>(run.moving().count()) * 1e-6;
  m.speed = wall_s > 0 ? static_cast<double>(m.stamp_us) * 1e-6 / wall_s : 0;
  m.can_wait = run.arena().info().can_wait;
  m.counters = hal::to_message(run.drops());
  for (counter_t& c : hal::to_message(run.lab().counts())) {
    c.name.insert(0, "counts.");
    m.counters.push_back(std::move(c));
  }
  // A command is given as of this moment (operator_command_t).
  counter_t& clock = m.counters.emplace_back();
  clock.name = "operator.clock_us";
  clock.value = run.now().count();
  m.n_counters = static_cast<std::int32_t>(m.counters.size());
  return m;
}

}  // namespace arkmesh::lab
