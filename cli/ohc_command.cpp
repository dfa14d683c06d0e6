// `arkmesh ohc`: drives an overhead controller by hand, one command at a time, and puts programs on robots.
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/progress_line.hpp"
#include "hal/counted.hpp"
#include "hal/exit_code.hpp"
#include "hal/platforms/kilobot/intel_hex.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "hal/platforms/kilobot/ohc_packets.hpp"
#include "hal/platforms/kilobot/ohc_session.hpp"

namespace arkmesh::cli {
namespace {

using namespace hal::kilobot;

struct OhcOptions {
  std::string port;
  double seconds = 0;  // 0: what suits the command
  double settle_s = 2.5;
  std::vector<std::string> numbers;
  bool yes = false;  // what reaches every robot is done without asking
  std::filesystem::path program;
  int rounds = 0;  // 0: until somebody stops it
  double boot_s = 3, page_ms = 165;
};

std::chrono::microseconds from_seconds(double seconds) {
  return std::chrono::microseconds{static_cast<std::int64_t>(seconds * 1e6)};
}

// Runs the work of a command, which returns false when it was stopped. What it says of the command line becomes
// CLI11's.
template <class Work>
void run_ohc(Work work) {
  try {
    if (!work()) throw CLI::RuntimeError(1);
  } catch (const WrongWord& wrong) {
    throw CLI::ValidationError(wrong.name(), wrong.what());
  } catch (const PortTaken& taken) {
    throw hal::ExitError(hal::Exit::port_taken, taken.what());
  } catch (const PortError& wrong) {
    throw CLI::ValidationError("PORT", wrong.what());
  }
}

std::vector<Packet> give_id(const std::string& text) {
  const std::uint16_t id = parse_number(text, 65535, "N");
  if (id > largest_id(ark_layout))
    fmt::print(stderr, "arkmesh: robots with ids above {} cannot be addressed one by one\n", largest_id(ark_layout));
  return set_id_packets(id);
}

// Whether the person at the terminal wants `what`, a sentence without its full stop. Where nobody can be asked, --yes
// must have been given.
bool is_wanted(const std::string& what) {
  if (!::isatty(STDIN_FILENO))
    throw CLI::ValidationError("--yes",
                               fmt::format("is needed without a terminal, where arkmesh cannot ask: {}", what));
  fmt::print(stderr, "{}. Continue? [y/N] ", what);
  OperatorStop stop;
  pollfd typed{STDIN_FILENO, POLLIN, 0};
  while (::poll(&typed, 1, 100) <= 0)
    if (stop.stopped()) return false;
  std::string answer;
  std::getline(std::cin, answer);
  if (answer == "y" || answer == "yes") return true;
  fmt::print(stderr, "arkmesh: nothing was sent\n");
  return false;
}

// `then`: what an operator has to know or do next.
bool say(const OhcOptions& options, const OhcCommand& command, const std::string& then) {
  OperatorStop stop;
  ProgressLine status;
  OhcSession session(options.port, from_seconds(options.settle_s), stop, status);
  const OhcSaid said = session.say(command);
  if (said.all)
    fmt::print("{}: sent for {:.3g} s{}\n", command.name, said.of_seconds, then);
  else
    fmt::print(stderr, "arkmesh: {} was stopped after {:.1f} of {:.1f} s{}\n", command.name, said.seconds,
               said.of_seconds, then);
  return said.all;
}

void add_commands(CLI::App& ohc, const std::shared_ptr<OhcOptions>& options) {
  // `packets` is called when the command is, so that its numbers are there
  const auto add = [&ohc, options](const std::string& name, const std::string& help, double usual_s, auto packets,
                                   const std::string& then = {}) {
    CLI::App* command = ohc.add_subcommand(name, help)->fallthrough();
    command->callback([options, name, usual_s, packets, then] {
      run_ohc([&] {
        const OhcCommand said{name, packets(), from_seconds(options->seconds > 0 ? options->seconds : usual_s),
                              name != "stop" && name != "lamp" && name != "message"};
        if (name == "set-uid" && !options->yes &&
            !is_wanted(fmt::format("Every robot in range will store the id {}", options->numbers.at(0))))
          return false;
        return say(*options, said, then);
      });
    });
    return command;
  };
  const auto add_plain = [&add](const std::string& name, const std::string& help, double usual_s, std::uint8_t type) {
    add(name, help, usual_s, [type] { return std::vector{plain_packet(type)}; });
  };
  add_plain("run", "Start the robots' program, or resume it after a pause", 1, type_run);
  add_plain("pause", "Stop the robots, which flash green; `run` resumes", 1, type_wakeup);
  add_plain("reset", "Restart robots", 1, type_reset);
  add_plain("sleep", "Put robots to sleep; they listen every 8 s", 1, type_sleep);
  add_plain("wake", "Wake sleeping robots: pause, sent for longer than 8 s", 10, type_wakeup);
  add_plain("voltage", "Show each robot's battery level: green, blue, yellow, red", 1, type_voltage);
  add_plain("charge", "Show red LEDs while robots charge", 1, type_charge);
  add("stop", "Stop transmitting", 0.04, [] { return std::vector<Packet>{stop_packet()}; });
  add("lamp", "Switch the controller's lamp on or off", 0.04, [] { return std::vector{led_toggle_packet()}; });

  const auto take = [options](CLI::App* command, const std::string& name, const std::string& help, int least,
                              int most) {
    command->add_option(name, options->numbers, help)->required()->expected(least, most);
  };
  take(add("message", "Send a message to the robots' program", 1,
           [options] { return std::vector{message_packet(options->numbers)}; }),
       "TYPE_AND_BYTES", "Type 0 to 127, then up to 9 bytes, decimal or 0x...", 1, 1000);
  CLI::App* const set_uid = add("set-uid", "Store the id N in every robot in range: place only one there", 1,
                                [options] { return give_id(options->numbers.at(0)); });
  take(set_uid, "N", "0 to 65535", 1, 1);
  set_uid->add_flag("--yes", options->yes, "Do not ask for confirmation");
  const std::string moving = "; robots continue until `pause`, or until `save`, which stores the duties";
  const auto turn = [&](const std::string& way, Packet (*packet)(const std::string& duty)) {
    const auto packets = [options, packet] { return std::vector{packet(options->numbers.at(0))}; };
    take(add(way, fmt::format("Turn robots {} with this duty", way), 1, packets, moving), "DUTY",
         "0 to 255; good ones are 60 to 75", 1, 1);
  };
  turn("left", turn_left_packet);
  turn("right", turn_right_packet);
  take(add(
           "straight", "Drive robots straight with these duties", 1,
           [options] { return std::vector{straight_packet(options->numbers.at(0), options->numbers.at(1))}; }, moving),
       "LEFT_AND_RIGHT", "Each 0 to 255; a little lower than for turning", 2, 2);
  add("save", "Make robots store the received duties and id, and stop", 1, [] { return std::vector{save_packet()}; });
}

// Returns whether a whole round was sent.
bool upload(const OhcOptions& options) {
  Firmware firmware = read_intel_hex(options.program);
  const std::size_t bytes = firmware.size_bytes();
  std::optional<int> rounds;
  if (options.rounds > 0) rounds = options.rounds;
  FirmwareUpload upload(std::move(firmware), rounds,
                        {.boot_for = from_seconds(options.boot_s), .spacing = from_seconds(options.page_ms / 1000)});
  OperatorStop stop;
  ProgressLine status;
  OhcSession session(options.port, from_seconds(options.settle_s), stop, status);
  status.done();
  fmt::print("{}: {}, {}, {:.1f} s a round{}\n", options.program.filename().string(), hal::counted(bytes, "byte"),
             hal::counted(upload.pages(), "page"), std::chrono::duration<double>(upload.round_time()).count(),
             rounds ? "" : "; press Ctrl-C when every robot runs the new program");
  std::fflush(stdout);
  const auto begun = std::chrono::steady_clock::now();
  session.upload(upload);
  const std::string sent = upload.round() == 0   ? fmt::format("{}", upload.page())
                           : upload.round() == 1 ? "1 round"
                                                 : fmt::format("{} rounds", upload.round());
  fmt::print("{} of {} sent{}, {:.0f} s\n", sent, hal::counted(upload.pages(), "page"),
             stop.stopped() ? ", stopped" : "",
             std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
  return upload.round() > 0;
}

void add_upload(CLI::App& ohc, const std::shared_ptr<OhcOptions>& options) {
  CLI::App* command =
      ohc.add_subcommand("upload", "Load a program (Intel HEX) onto all robots in range, in repeated rounds")
          ->fallthrough();
  command->add_option("PROGRAM", options->program, "The .hex file from avr-objcopy")->required();
  command->add_option("--rounds", options->rounds, "Stop after this many rounds (default: continue until Ctrl-C)")
      ->check(CLI::Range(1, 1'000'000));
  command
      ->add_option("--boot", options->boot_s,
                   "Call the robots to their boot loaders for this many seconds; sleeping robots need 10")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  command
      ->add_option("--page-ms", options->page_ms,
                   "Time from the start of a page to the next; below 132 the controller loses some")
      ->check(CLI::Range(132.0, 10'000.0))
      ->capture_default_str();
  command->footer(
      "Example:\n  arkmesh ohc /dev/ttyUSB0 upload build/robot.hex\n"
      "Robots flash blue while waiting, green at each page, and start the program once it is complete. They\nconfirm "
      "nothing: watch them, and press Ctrl-C when the last one has the program. Exit code 1\nif not even one round was "
      "sent.");
  command->callback([options] { run_ohc([&] { return upload(*options); }); });
}

}  // namespace

void add_ohc_command(CLI::App* ohc) {
  const auto options = std::make_shared<OhcOptions>();
  ohc->add_option("PORT", options->port,
                  "A serial device such as /dev/ttyUSB0, or tcp://host:port (ser2net, arkmesh emulator)")
      ->required();
  ohc->add_option("--seconds", options->seconds, "Repeat the command for this many seconds (default 1; wake 10)")
      ->check(CLI::Range(0.04, 86400.0));
  ohc->add_option("--settle", options->settle_s, "Seconds to wait after opening the port, which restarts some boards")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  ohc->require_subcommand(1);
  ohc->footer(
      "Examples:\n  arkmesh ohc /dev/ttyUSB0 run\n  arkmesh ohc /dev/ttyUSB0 message 120 0 7 --seconds 5\n"
      "  arkmesh ohc /dev/ttyUSB0 set-uid 12\n"
      "  arkmesh ohc /dev/ttyUSB0 upload build/robot.hex\n  arkmesh ohc tcp://192.168.1.20:3001 pause\n"
      "Each subcommand has a --help of its own. At the end, also after Ctrl-C, arkmesh stops the controller's "
      "transmission.\n"
      "If arkmesh was killed, or the cable pulled, the controller keeps transmitting:\nstop it with `arkmesh ohc PORT "
      "stop`. Exit code 1 if the controller cannot be reached, 5 if another program\nuses it. A guard left behind by a "
      "lab yields, and resumes if the command does not reach the robots.");
  ohc->parse_complete_callback([] { OperatorStop(); });  // from now on
  add_commands(*ohc, options);
  add_upload(*ohc, options);
}

}  // namespace arkmesh::cli
