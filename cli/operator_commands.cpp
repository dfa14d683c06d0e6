// `arkmesh stop`, `pause` and `resume`: an operator's word to a lab that runs, from any terminal, over the lab's bus.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>

#include "arkmesh/fleet_command_t.hpp"
#include "cli/bus_options.hpp"
#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "cli/running_lab.hpp"
#include "lab/operator_key.hpp"
#include "lab/operator_message.hpp"

namespace arkmesh::cli {
namespace {

struct OperatorWord {
  const char* name;
  std::uint8_t command;
  const char* done;  // what is said of the lab afterwards
};

constexpr OperatorWord stop_word{"stop", operator_command_t::stop, "ended at period"};
constexpr OperatorWord pause_word{"pause", fleet_command_t::pause, "paused its robots at period"};
constexpr OperatorWord resume_word{"resume", fleet_command_t::run, "lets its robots go on from period"};

void tell(const OperatorWord& word, const hal::BusConfig& bus) {
  lab::OperatorKey key;
  key.make();
  key.read();
  RunningLab lab(bus);
  if (!lab.speaks())
    throw std::runtime_error(fmt::format(
        "no lab speaks on {}; is it running, and is this its file? (arkmesh {} --help)", bus.url, word.name));
  if (lab.has_ended()) throw std::runtime_error(fmt::format("{} has ended already: {}", lab.name(), lab.state()));
  const std::string why = lab.tell(word.command, [&](operator_command_t& message) {
    const auto proof = key.prove(lab::proved_bytes(message)).value();
    std::ranges::copy(proof, message.proof);
  });
  if (!why.empty()) throw std::runtime_error(why);
  if (word.command == operator_command_t::stop &&
      !lab.comes_to(std::chrono::seconds(10), [&] { return lab.has_ended(); }))
    throw std::runtime_error(fmt::format("{} was told to end, but has not said within 10 s that it did", lab.name()));
  fmt::print("{} {} {}{}\n", lab.name(), word.done, lab.period(),
             lab.has_ended() ? "" : fmt::format(" ({})", lab.state()));
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
