#include "lab/operator/running_lab.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <random>

#include "hal/arenas/robot_words.hpp"
#include "hal/label.hpp"
#include "lab/operator/operator_message.hpp"
#include "lab/safety_config.hpp"

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr int attempts = 3;
const std::string own_number = "operator.number";
// Another attempt would be refused as well.
constexpr std::string_view final_reasons[] = {"no_peers", "no_permission", "not_armed", "not_for_peers"};
constexpr std::string_view refused_prefix = "operator.refused.";

// By reason.
std::map<std::string, std::int64_t> refusals(const lab_status_t& status) {
  std::map<std::string, std::int64_t> out;
  for (const counter_t& counter : status.counters)
    if (counter.name.starts_with(refused_prefix)) out[counter.name.substr(refused_prefix.size())] = counter.value;
  return out;
}

}  // namespace

// Of several that claim to be the lab the first is believed; what another lab is told it refuses.
RunningLab::RunningLab(const hal::BusConfig& bus, const std::string& name, const std::string& own)
    : bus_(bus.url, bus.hear),
      number_counter_(own_number + (own.empty() ? "" : '.' + own)),
      statuses_(bus_.subscribe(
          (own.empty() ? "" : name + '/') + hal::channel::status, [this, name](std::string_view, auto bytes) {
            lab_status_t status;
            if (!hal::decode(bytes, status)) return;
            if (!name.empty() && status.lab != name) return;
            if (statuses_heard_ > 0 && (status.lab != status_.lab || status.nonce != status_.nonce)) return;
            status_ = status;
            status_.lab = hal::printable(status.lab, hal::max_lab_name);
            status_.state = hal::printable(status.state, 200);
            ++statuses_heard_;
            heard_at_ = std::chrono::steady_clock::now();
          })) {
  if (!own.empty()) return;  // another lab's status crosses each second
  operator_command_t ask{};
  ask.command.command = operator_command_t::ask;
  bus_.publish(operator_channel, ask);
}

bool RunningLab::comes_to(std::chrono::milliseconds within, const std::function<bool()>& condition) {
  const auto until = std::chrono::steady_clock::now() + within;
  while (statuses_heard_ == 0 || !condition()) {
    if (std::chrono::steady_clock::now() >= until) return false;
    bus_.drain(20ms);
  }
  return true;
}

std::string RunningLab::not_standing() const {
  return hal::in_words(not_seen());
}

bool RunningLab::stands() const {
  return should_stand() && stand(not_seen(), static_cast<std::size_t>(counter("robots.may_be_missing")));
}

std::vector<hal::NotStanding> RunningLab::not_seen() const {
  std::vector<hal::NotStanding> robots;
  for (const not_standing_t& robot : status_.not_standing) robots.push_back(hal::from_message(robot));
  return robots;
}

bool RunningLab::speaks() {
  return comes_to(2500ms, [] { return true; });
}

std::int64_t RunningLab::counter(std::string_view name) const {
  const auto it = std::ranges::find(status_.counters, name, &counter_t::name);
  return it == status_.counters.end() ? 0 : it->value;
}

std::string RunningLab::tell(std::uint8_t command, const std::function<void(operator_command_t&)>& prove) {
  const auto before = refusals(status_);
  operator_command_t message{};
  message.lab = status_.lab;
  message.run_id = status_.nonce;
  message.command.command = command;
  std::string reasons;
  bool again = true;
  for (int i = 0; i < attempts && again; ++i) {
    if (admits(message, prove)) return {};
    reasons.clear();
    for (const auto& [reason, n] : refusals(status_)) {
      if (const auto it = before.find(reason); it != before.end() && it->second == n) continue;
      reasons += (reasons.empty() ? "" : ", ") + hal::printable(reason, 60);
      again = again && std::ranges::find(final_reasons, reason) == std::end(final_reasons);
    }
  }
  if (!reasons.empty())
    return fmt::format("{} refused it: {}; it says why, and docs/security.md what to do", name(), reasons);
  if (number_counter_ != own_number)
    return fmt::format(
        "{} has not answered within 10 s; does this lab's gateway export operator_command, and does {}'s "
        "import it? (docs/security.md)",
        name(), name());
  return fmt::format("{} has not answered within 10 s; its robots are paused by hand with: arkmesh ohc PORT pause",
                     name());
}

// A status that comes after the message may have been on its way; the second one tells, if the lab heard it.
bool RunningLab::admits(operator_command_t& message, const std::function<void(operator_command_t&)>& prove) {
  std::random_device device;
  const std::int64_t newest = counter(number_counter_);
  message.clock_us = counter("operator.clock_us");
  message.number = newest + std::uniform_int_distribution<std::int64_t>(1, number_window)(device);
  prove(message);
  bus_.publish(operator_channel, message);
  const int heard = statuses_heard_;
  const bool ends = message.command.command == operator_command_t::stop;
  const auto admitted = [&] { return counter(number_counter_) >= message.number || (ends && is_over()); };
  comes_to(3400ms, [&] { return admitted() || statuses_heard_ >= heard + 2; });
  return admitted();
}

}  // namespace arkmesh::lab
