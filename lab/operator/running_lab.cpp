#include "lab/operator/running_lab.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "hal/label.hpp"
#include "lab/operator/operator_message.hpp"

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr int attempts = 3;

}  // namespace

// Of several that claim to be the lab the first is believed; what another lab is told it refuses.
RunningLab::RunningLab(const hal::BusConfig& bus, const std::string& name, const std::string& own)
    : bus_(bus.url, bus.hear),
      other_(!own.empty()),
      statuses_(bus_.subscribe((own.empty() ? "" : name + '/') + hal::channel::status,
                               [this, name](std::string_view, auto bytes) {
                                 lab_status_t status;
                                 if (!hal::decode(bytes, status) || (!name.empty() && status.lab != name)) return;
                                 if (has_spoken() && (status.lab != status_.lab || status.nonce != status_.nonce))
                                   return;
                                 status_ = status;
                                 status_.lab = hal::printable(status.lab, hal::max_lab_name);
                                 status_.state = hal::printable(status.state, 200);
                                 not_seen_.clear();
                                 for (const not_standing_t& robot : status.not_standing)
                                   not_seen_.push_back(hal::from_message(robot));
                                 heard_at_ = std::chrono::steady_clock::now();
                               })),
      answers_(bus_.subscribe((own.empty() ? "" : name + '/') + answer_channel, [this](std::string_view, auto bytes) {
        operator_answer_t answer;
        if (hal::decode(bytes, answer) && answer.number == number_ && !answer_ &&
            (!has_spoken() || answer.run_id == status_.nonce))
          answer_ = answer;
      })) {
  ask();
}

void RunningLab::ask() {
  number_ = 0;
  answer_.reset();
  bus_.publish(operator_channel, question());
}

bool RunningLab::comes_to(std::chrono::milliseconds within, const std::function<bool()>& condition) {
  const auto until = std::chrono::steady_clock::now() + within;
  while (!has_spoken() || !condition()) {
    if (std::chrono::steady_clock::now() >= until) return false;
    bus_.drain(20ms);
  }
  return true;
}

std::string RunningLab::tell(std::uint8_t command, const std::function<void(operator_command_t&)>& prove) {
  operator_command_t message{};
  message.lab = status_.lab;
  message.run_id = status_.nonce;
  message.command.command = command;
  std::random_device device;
  const auto answered = [&] { return answer_ || (command == operator_command_t::stop && is_over()); };
  std::string why;
  for (int i = 0; i < attempts; ++i) {
    if (number_ != 0 || i > 0 || (answer_ && answer_->run_id != status_.nonce)) ask();
    if (!comes_to(3400ms, answered)) continue;
    if (answer_) message.clock_us = answer_->clock_us;
    message.number = number_ = std::uniform_int_distribution<std::int64_t>(1)(device);
    prove(message);
    answer_.reset();
    bus_.publish(operator_channel, message);
    if (!comes_to(3400ms, answered)) continue;
    if (!answer_ || answer_->refusal.empty()) return {};
    const std::string refusal = answer_->refusal;
    why = fmt::format("{} refused the command: {}; its log gives the reason, docs/security.md the remedy", status_.lab,
                      hal::printable(refusal, 60));
    if (refusal != "too_often" && refusal != "too_old") break;
    comes_to(1s, [] { return false; });  // it may do it then
  }
  if (!why.empty()) return why;
  if (other_) return not_reached(status_.lab) + " (docs/security.md)";
  return fmt::format("{} has not answered within 10 s; to pause its robots by hand: arkmesh ohc PORT pause",
                     status_.lab);
}

}  // namespace arkmesh::lab
