#include "lab/status.hpp"

#include <utility>

#include "hal/arenas/messages.hpp"
#include "lab/result.hpp"
#include "lab/runner.hpp"

namespace arkmesh::lab {
namespace {

constexpr std::size_t most_not_standing = 1000;

std::uint8_t wanted_of(hal::FleetCommand::Kind kind) {
  using Kind = hal::FleetCommand::Kind;
  switch (kind) {
    case Kind::run:
      return lab_status_t::run;
    case Kind::sleep:
      return lab_status_t::asleep;
    case Kind::charge:
      return lab_status_t::charging;
    case Kind::voltage:
      return lab_status_t::showing_voltage;
    default:
      return lab_status_t::still;
  }
}

}  // namespace

lab_status_t status_of(const Runner& run) {
  lab_status_t m;
  m.lab = run.config().lab;
  m.nonce = static_cast<std::int64_t>(run.run_id());
  m.phase = run.phase();
  m.outcome = run.outcome_code();
  m.state = run.state_text() + (run.armed() ? ", armed" : "");
  m.wanted = wanted_of(run.robot_book().wanted());
  m.kept_still = run.robot_book().kept_still_by();
  for (const hal::NotStanding& robot : run.not_standing()) {
    if (m.not_standing.size() == most_not_standing) break;
    m.not_standing.push_back(hal::to_message(robot));
  }
  m.n_not_standing = static_cast<std::int32_t>(m.not_standing.size());
  m.may_be_missing = static_cast<std::int32_t>(run.may_be_missing());
  m.obeys = run.config().safety.commands_from;
  m.n_obeys = static_cast<std::int32_t>(m.obeys.size());
  m.stamp_us = run.arena().clock().now().count();
  m.period = static_cast<std::int32_t>(run.period());
  m.last_period = static_cast<std::int32_t>(run.last_period());
  const double wall_s = static_cast<double>(run.moving().count()) * 1e-6;
  m.speed = wall_s > 0 ? static_cast<double>(m.stamp_us) * 1e-6 / wall_s : 0;
  m.can_wait = run.arena().info().can_wait;
  m.settings = hash_text(run.settings_hash());
  m.counters = hal::to_message(run.drops());
  for (counter_t& c : hal::to_message(run.lab().counts())) {
    c.name.insert(0, "counts.");
    m.counters.push_back(std::move(c));
  }
  m.n_counters = static_cast<std::int32_t>(m.counters.size());
  return m;
}

}  // namespace arkmesh::lab
