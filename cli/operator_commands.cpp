// `arkmesh stop`, `pause` and `resume`: an operator's word to a lab that runs, from any terminal, over the lab's bus.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>

#include "arkmesh/lab_status_t.hpp"
#include "cli/bus_options.hpp"
#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "hal/bus.hpp"
#include "hal/label.hpp"
#include "hal/messages.hpp"
#include "lab/arena_port.hpp"
#include "lab/message_check.hpp"

namespace arkmesh::cli {
namespace {

using namespace std::chrono_literals;

// The lab on a bus, as its status tells.
class RunningLab {
 public:
  explicit RunningLab(const hal::BusConfig& bus)
      : bus_(bus.url, bus.hear), statuses_(bus_.subscribe(hal::channel::status, [this](std::string_view, auto bytes) {
          lab_status_t status;
          if (lab::check_status(bytes).empty() && hal::decode(bytes, status)) status_ = status;
        })) {}

  // False when it has not come to that in time.
  template <class Condition>
  bool comes_to(std::chrono::milliseconds within, Condition condition) {
    const auto until = std::chrono::steady_clock::now() + within;
    while (status_.lab.empty() || !condition()) {
      if (std::chrono::steady_clock::now() >= until) return false;
      bus_.drain(20ms);
    }
    return true;
  }
  bool speaks() {
    return comes_to(2500ms, [] { return true; });
  }
  void say(std::uint8_t command) {
    fleet_command_t message{};
    message.command = command;
    bus_.publish(lab::ArenaPort::operator_channel, message);
  }
  bool has_ended() const { return status_.state.starts_with("failed") || status_.state.starts_with("finished"); }
  std::int64_t commands_heard() const {
    for (const counter_t& counter : status_.counters)
      if (counter.name == "operator.commands") return counter.value;
    return 0;
  }
  const lab_status_t& status() const { return status_; }

 private:
  hal::Bus bus_;
  lab_status_t status_;
  std::unique_ptr<hal::Bus::Subscription> statuses_;
};

struct OperatorWord {
  const char* name;
  std::uint8_t command;
  const char* done;  // what is said of the lab afterwards
};

constexpr OperatorWord stop_word{"stop", lab::ArenaPort::end_run, "ended at period"};
constexpr OperatorWord pause_word{"pause", fleet_command_t::pause, "paused its robots at period"};
constexpr OperatorWord resume_word{"resume", fleet_command_t::run, "lets its robots go on from period"};

void tell(const OperatorWord& word, const hal::BusConfig& bus) {
  RunningLab lab(bus);
  if (!lab.speaks())
    throw std::runtime_error(fmt::format(
        "no lab speaks on {}; is it running, and is this its file? (arkmesh {} --help)", bus.url, word.name));
  const std::string name = lab.status().lab;
  const std::int64_t before = lab.commands_heard();
  if (lab.has_ended()) throw std::runtime_error(fmt::format("{} has ended already: {}", name, lab.status().state));
  lab.say(word.command);
  const bool heard = lab.comes_to(
      10s, [&] { return word.command == lab::ArenaPort::end_run ? lab.has_ended() : lab.commands_heard() > before; });
  if (!heard)
    throw std::runtime_error(fmt::format(
        "{} has not answered within 10 s; its robots are paused by hand with: arkmesh ohc PORT pause", name));
  const std::string now = lab.has_ended() ? "" : fmt::format(" ({})", hal::printable(lab.status().state, 200));
  fmt::print("{} {} {}{}\n", name, word.done, lab.status().period, now);
}

// `word` lives as long as the process.
void add_operator_command(CLI::App& app, const OperatorWord& word) {
  CLI::App* command = add_command(app, word.name);
  const auto options = std::make_shared<BusOptions>();
  options->add_to(*command);
  command->footer(fmt::format("Example:\n  arkmesh {} experiments/dhtf/shark.toml", word.name));
  command->callback([&word, options] { tell(word, options->bus()); });
}

}  // namespace

void add_stop_command(CLI::App& app) {
  add_operator_command(app, stop_word);
}
void add_pause_command(CLI::App& app) {
  add_operator_command(app, pause_word);
}
void add_resume_command(CLI::App& app) {
  add_operator_command(app, resume_word);
}

}  // namespace arkmesh::cli
