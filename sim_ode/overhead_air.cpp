#include "sim_ode/overhead_air.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "hal/platforms/kilobot/layout.hpp"

namespace arkmesh::sim_ode {

OverheadAir::OverheadAir(const Settings& settings, const hal::ArenaInfo& info, const ContactWorld& world,
                         InfraredMedium& infrared, OverheadSource* source, const std::string& lab, std::uint64_t seed,
                         hal::Counters& counters)
    : settings_(settings),
      info_(info),
      world_(world),
      infrared_(infrared),
      source_(source),
      counters_(counters),
      loss_chance_(seed, lab + "/ode/overhead_loss") {}

hal::kilobot::MessageRegisters::SetPoints OverheadAir::send_composite(hal::LabTime now, std::int64_t tick_began_us,
                                                                      hal::kilobot::MessageRegisters& registers,
                                                                      std::vector<Inbox::Overhead>& inbox) {
  auto outgoing = registers.next();
  if (!outgoing) return {};
  infrared_.overhead_sends(now.count());
  Inbox::Overhead heard;
  heard.at_us = static_cast<std::uint32_t>(now.count() - tick_began_us);
  heard.message = outgoing->message;
  // fleet commands are repeated until everybody has heard them
  if (loses() && heard.message.type <= 127) draw_missed(heard);
  if (outgoing->only_to) hide_from_others(heard, {*outgoing->only_to});
  if (settings_.infrared == InfraredRules::argos && outgoing->has_words) {  // others keep what they were told
    std::vector<hal::RobotId> receivers;
    for (std::size_t group = 0; group < hal::kilobot::groups; ++group)
      receivers.push_back(hal::kilobot::word_in(heard.message, group, hal::kilobot::layout_of(info_)).robot);
    hide_from_others(heard, receivers);
  }
  if (outgoing->is_command || !infrared_.repeats(heard)) inbox.push_back(std::move(heard));
  return std::move(outgoing->set_points);
}

// A controller cannot do that; other simulators can, and programs were written for them.
void OverheadAir::hide_from_others(Inbox::Overhead& heard, const std::vector<hal::RobotId>& robots) const {
  heard.missed.resize(info_.robots.size());
  for (std::size_t i = 0; i < heard.missed.size(); ++i)
    if (std::ranges::find(robots, info_.robots[i]) == robots.end()) heard.missed[i] = 1;
}

// Rises with the square of the distance from the arena's centre, above which the controller hangs, to its corners.
double OverheadAir::loss(std::size_t robot) const {
  const double centre = settings_.overhead_loss, corners = settings_.air.overhead_loss_edge;
  if (std::isnan(corners)) return centre;
  const double x = world_.x()[robot], y = world_.y()[robot], w = info_.width_m / 2, h = info_.height_m / 2;
  return centre + (corners - centre) * std::min(1.0, (x * x + y * y) / (w * w + h * h));
}

void OverheadAir::draw_missed(Inbox::Overhead& heard) {
  for (std::size_t i = 0; i < info_.robots.size(); ++i) {
    const bool missed = loss_chance_.uniform() < loss(i);
    heard.missed.push_back(missed);
    if (missed) counters_.add("to_robots.lost.overhead");
  }
}

std::span<const Transmission> OverheadAir::sent_until(hal::LabTime now) {
  source_->sent_until(now.count(), sent_);
  return sent_;
}

void OverheadAir::hear(hal::LabTime now, std::vector<Inbox::Overhead>& inbox) {
  sent_until(now);
  const std::int64_t since_us = now.count() - tick_us;
  for (const Transmission& sent : sent_) {
    if (!sent.clean || sent.message.crc != message_crc(sent.message)) {
      counters_.add(sent.clean ? "overhead.refused.crc" : "overhead.distorted");
      continue;
    }
    counters_.add("overhead.heard");
    Inbox::Overhead& heard = inbox.emplace_back();
    heard.at_us = static_cast<std::uint32_t>(std::clamp<std::int64_t>(sent.end_us - since_us, 0, tick_us - 1));
    heard.message = sent.message;
    if (loses()) draw_missed(heard);
    if (off_arena_ == 0) continue;
    heard.missed.resize(info_.robots.size());
    for (std::size_t i = 0; i < heard.missed.size(); ++i)
      if (!world_.in_arena(static_cast<int>(i))) heard.missed[i] = 1;
  }
  sent_.clear();
}

}  // namespace arkmesh::sim_ode
