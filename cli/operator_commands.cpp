// `arkmesh stop`, `pause`, `resume`, `reset`, `arm` and `disarm`: an operator's word to a lab that runs, from any
// terminal, over the lab's bus; with --at to a lab that it is joined with.
#include <fmt/format.h>
#include <poll.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "cli/bus_options.hpp"
#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "gateway/frame/signature.hpp"
#include "gateway/links/key_folder.hpp"
#include "hal/bus/participants.hpp"
#include "hal/child_process.hpp"
#include "hal/config/config.hpp"
#include "hal/exit_code.hpp"
#include "hal/label.hpp"
#include "lab/operator/operator_key.hpp"
#include "lab/operator/operator_message.hpp"
#include "lab/operator/running_lab.hpp"

namespace arkmesh::cli {
namespace {

using lab::OperatorWord;

constexpr std::chrono::seconds ends_within{25};  // 10 of them until robots were seen to stand
constexpr std::chrono::seconds seen_within{12};

struct OperatorOptions : BusOptions {
  std::string at;      // another lab
  bool world = false;  // all labs
};

// Fills in the proof of a command.
using Prove = std::function<void(operator_command_t&)>;

Prove prove_as_user(bool as_one_of_world) {
  lab::OperatorKey key;
  if (key.make()) std::this_thread::sleep_for(std::chrono::milliseconds(200));  // labs look for another one each 0.1 s
  key.read();
  return [key, as_one_of_world](operator_command_t& message) {
    message.command.type = as_one_of_world ? operator_command_t::of_world : 0;
    std::ranges::copy(key.prove(lab::proved_bytes(message)).value(), message.proof);
  };
}

// By the key that makes this lab known to the other one.
Prove prove_as_lab(const std::string& own, const std::filesystem::path& keys) {
  const std::string key = gateway::KeyFolder(keys).own(own).key_pem;
  return [key, own](operator_command_t& message) {
    const auto signature = gateway::sign(key, lab::proved_bytes(message));
    if (!signature)
      throw hal::ConfigError(
          fmt::format("the key of lab {} is not an Ed25519 key, which `arkmesh keys init` creates", own));
    std::ranges::copy(*signature, message.proof);
  };
}

// "Done" is said of robots that were seen to stand only. `options`: of the own lab, whose guard is on this machine.
void tell(const OperatorWord& word, lab::RunningLab& lab, const Prove& prove, const BusOptions& options) {
  const lab_status_t& now = lab.status();
  // Who ends because a peer was stopped is stopped, too.
  const bool ends = word.command == operator_command_t::stop;
  if (lab.is_over() && !ends) throw std::runtime_error(fmt::format("{} has ended already: {}", now.lab, now.state));
  const std::string why = lab.is_over() ? "" : lab.tell(word.command, prove);
  if (!why.empty() && !(ends && lab.is_over())) {
    const std::string hung = lab.is_silent() ? options.hung_words() : std::string();
    throw std::runtime_error(hung.empty() ? why : hung);
  }
  if (ends && !lab.comes_to(ends_within, [&] { return lab.has_ended(); }))
    throw std::runtime_error(fmt::format("{} has not confirmed its end within {} s", now.lab, ends_within.count()));
  if (word.makes_stand) lab.comes_to(seen_within, [&] { return lab.has_ended() || lab.stands(); });
  const std::string missing = lab.not_standing();
  if (word.makes_stand && !lab.stands())
    throw hal::ExitError(
        hal::Exit::not_standing,
        fmt::format("{} told its robots to stop; not seen standing: {}. {}", now.lab,
                    lab.should_stand() ? missing : "all of them, because it still makes them run",
                    ends ? "It has ended; its guard repeats the stop for a minute, and arkmesh ohc PORT pause sends it "
                           "again"
                         : "It repeats the stop until they are seen standing; stop moving robots by hand"));
  fmt::print("{} {} {}{}{}\n", now.lab, word.done, now.period, lab.has_ended() ? "" : fmt::format(" ({})", now.state),
             word.makes_stand && !missing.empty() ? "; state unknown for robots " + missing : "");
}

void tell_own(const OperatorWord& word, const OperatorOptions& options) {
  const hal::BusConfig bus = options.bus();
  const Prove prove = prove_as_user(options.world);
  lab::RunningLab lab(bus, options.lab());
  if (lab.speaks()) return tell(word, lab, prove, options);
  const std::string hung = options.hung_words();
  throw std::runtime_error(
      hung.empty() ? fmt::format("no lab is heard on {}; is it running, and is this its file? (arkmesh {} --help)",
                                 bus.url, word.name)
                   : hung);
}

void tell_other(const OperatorWord& word, const OperatorOptions& options) {
  if (!hal::is_lab_name(options.at))
    throw hal::ConfigError(fmt::format("--at '{}' is not a lab's name", hal::printable(options.at, hal::max_label)));
  const hal::Section root = hal::Config::from_file(options.file, options.sets).root();
  const std::string own = options.lab();
  const Prove prove = prove_as_lab(own, root.section("gateway").get("keys", std::filesystem::path()));
  const hal::BusConfig bus = options.bus();
  lab::RunningLab lab(bus, options.at, own);
  if (lab.speaks()) return tell(word, lab, prove, {});
  throw std::runtime_error(fmt::format("{} is not heard on {}; is the link to it up? (arkmesh status {})", options.at,
                                       bus.url, options.file));
}

void tell_one(const OperatorWord& word, const OperatorOptions& options) {
  options.at.empty() ? tell_own(word, options) : tell_other(word, options);
}

// To all labs of shared.labs at once, each by a process of its own. Each says what came of it; the exit code is that of
// robots that may walk, before any other failure.
void tell_world(const OperatorWord& word, OperatorOptions options) {
  const auto shared = hal::Config::from_file(options.file, options.sets).root().read<hal::Participants>();
  std::vector<hal::ChildProcess> children;
  std::vector<std::string> labs = shared.labs;
  std::ranges::stable_partition(labs, [&](const std::string& lab) { return lab == shared.lab; });  // said first
  for (const std::string& lab : labs) {
    options.at = lab == shared.lab ? "" : lab;
    children.emplace_back(hal::ChildStart{
        .function = [&word, options] { return exit_code_of([&] { return tell_one(word, options), hal::Exit::done; }); },
        .last_signal = SIGTERM});
  }
  int code = hal::Exit::done;
  for (hal::ChildProcess& child : children) {
    std::string said;
    while (child.read(said)) {
      pollfd more{child.output(), POLLIN, 0};
      ::poll(&more, 1, -1);
    }
    const int one = child.wait().code;
    fmt::print(one == hal::Exit::done ? stdout : stderr, "{}", said);
    if (one == hal::Exit::not_standing || code == hal::Exit::done) code = one > 128 ? hal::Exit::failed : one;
  }
  end_with(code);
}

}  // namespace

void add_operator_command(CLI::App* command) {
  const OperatorWord& word = *std::ranges::find(lab::operator_words, command->get_name(), &OperatorWord::name);
  const auto options = std::make_shared<OperatorOptions>();
  options->add_to(*command);
  std::string examples = fmt::format("Examples:\n  arkmesh {} experiments/dhtf/shark.toml", word.name);
  if (word.at_others) {
    command
        ->add_option("--at", options->at,
                     "Send to another lab, which must accept commands from this lab's operator; FILE is this lab's")
        ->type_name("LAB")
        ->needs("file");
    command
        ->add_flag("--world", options->world,
                   "Send to all labs of shared.labs that accept commands from this lab's operator")
        ->excludes("--at")
        ->needs("file");
    examples += fmt::format(
        "\n  arkmesh {0} --at shark experiments/dhtf/roark.toml   # at roark, if shark accepts its commands "
        "(docs/security.md)"
        "\n  arkmesh {0} --world experiments/dhtf/roark.toml      # both",
        word.name);
  }
  command->footer(examples);
  command->callback([&word, options] { options->world ? tell_world(word, *options) : tell_one(word, *options); });
}

}  // namespace arkmesh::cli
