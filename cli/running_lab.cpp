#include "cli/running_lab.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <random>

#include "hal/label.hpp"
#include "hal/messages.hpp"
#include "lab/message_check.hpp"
#include "lab/operator_message.hpp"

namespace arkmesh::cli {
namespace {

using namespace std::chrono_literals;

constexpr int attempts = 3;
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
RunningLab::RunningLab(const hal::BusConfig& bus)
    : bus_(bus.url, bus.hear), statuses_(bus_.subscribe(hal::channel::status, [this](std::string_view, auto bytes) {
        lab_status_t status;
        if (!lab::check_status(bytes).empty() || !hal::decode(bytes, status)) return;
        if (statuses_heard_ > 0 && (status.lab != status_.lab || status.nonce != status_.nonce)) return;
        status_ = status;
        status_.lab = hal::printable(status.lab, hal::max_lab_name);
        status_.state = hal::printable(status.state, 200);
        ++statuses_heard_;
      })) {}

bool RunningLab::comes_to(std::chrono::milliseconds within, const std::function<bool()>& condition) {
  const auto until = std::chrono::steady_clock::now() + within;
  while (statuses_heard_ == 0 || !condition()) {
    if (std::chrono::steady_clock::now() >= until) return false;
    bus_.drain(20ms);
  }
  return true;
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
  for (int i = 0; i < attempts; ++i)
    if (admits(message, prove)) return {};
  std::string reasons;
  for (const auto& [reason, n] : refusals(status_))
    if (const auto it = before.find(reason); it == before.end() || it->second < n)
      reasons += (reasons.empty() ? "" : ", ") + hal::printable(reason, 60);
  if (!reasons.empty())
    return fmt::format("{} refused it: {}; it says why, and docs/security.md what to do", name(), reasons);
  return fmt::format("{} has not answered within 10 s; its robots are paused by hand with: arkmesh ohc PORT pause",
                     name());
}

// A status that comes after the message may have been on its way; the second one tells, if the lab heard it.
bool RunningLab::admits(operator_command_t& message, const std::function<void(operator_command_t&)>& prove) {
  std::random_device device;
  const std::int64_t newest = counter("operator.number");
  message.number = newest + std::uniform_int_distribution<std::int64_t>(1, lab::number_window)(device);
  prove(message);
  bus_.publish(lab::operator_channel, message);
  const int heard = statuses_heard_;
  const bool ends = message.command.command == operator_command_t::stop;
  const auto admitted = [&] { return counter("operator.number") >= message.number || (ends && has_ended()); };
  comes_to(3400ms, [&] { return admitted() || statuses_heard_ >= heard + 3; });
  return admitted();
}

}  // namespace arkmesh::cli
