// What a runner says of its lab.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "hal/arenas/robot_words.hpp"
#include "lab/operator/operator_message.hpp"
#include "lab/runner.hpp"

namespace arkmesh::lab {

std::string_view Runner::outcome() const {
  if (failed_) return stopped_ ? "stopped" : "failed";
  return phase_ < Phase::lingering ? "running" : "finished";
}

void Runner::publish_status() {
  if (public_bus_) peers_.note_unsent(public_bus_->counters()["refused.send_failed"]);
  bus_.publish(hal::channel::status, status_of(*this));
  for (const operator_answer_t& answer : operators_.take_answers(now_)) bus_.publish(answer_channel, answer);
  status_said_ = now_;
  status_due_ = now_ + repeat_status;
  recorder_.flush();
  // A peer that waits while this lab computes, or waits for its arena, hears that it still counts.
  if (begun_ && phase_ != Phase::ended) peers_.repeat_world();
}

std::string Runner::state_text() const {
  std::string out = state_.text(), frozen = data_.growth.frozen(config_.owner);
  if (!frozen.empty()) frozen.insert(0, "; ");
  if (phase_ < Phase::lingering && !book_.is_paused()) return out + frozen;
  if (out == "running") out += fmt::format(", with its robots paused by the {}", book_.kept_still_by());
  if (phase_ < Phase::lingering) out += frozen;
  if (const std::string seen = hal::in_words(not_standing()); !seen.empty())
    out += fmt::format("; robots were told to stop; not seen standing: {}", seen);
  return out;
}

std::uint8_t Runner::phase() const {
  switch (phase_) {
    case Phase::starting:
      return lab_status_t::starting;
    case Phase::at_boundary:
    case Phase::running:
    case Phase::completing:
      return state_.waits.empty() ? lab_status_t::going_on : lab_status_t::waiting;
    case Phase::lingering:
    case Phase::failing:
      return lab_status_t::ending;
    case Phase::ended:
      break;
  }
  return lab_status_t::ended;
}

std::uint8_t Runner::outcome_code() const {
  if (failed_) return stopped_ ? lab_status_t::stopped : lab_status_t::failed;
  return phase_ < Phase::lingering ? lab_status_t::open : lab_status_t::finished;
}

std::vector<hal::NotStanding> Runner::not_standing() const {
  if (book_.wanted() == hal::FleetCommand::Kind::run) return {};
  return arena_.not_standing();
}

nlohmann::json Runner::exchange_figures() const {
  return peers_.exchange_figures();
}

hal::Counters Runner::drops() const {
  hal::Counters all = peers_.counters();
  all.merge(data_.growth.counters());
  all.merge(book_.counters());
  all.merge(port_.counters());
  all.merge(operators_.counters());
  all.merge(recorder_.counters());
  all.merge(bus_.counters(), "bus.");
  if (public_bus_) all.merge(public_bus_->counters(), "public_bus.");
  if (page_) all.merge(page_->counters());
  return all;
}

}  // namespace arkmesh::lab
