// `arkmesh ohc`: drives an overhead controller by hand, one command at a time, or puts a program on all robots.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/commands.hpp"
#include "hal/platforms/kilobot/firmware_upload.hpp"
#include "hal/platforms/kilobot/intel_hex.hpp"
#include "hal/platforms/kilobot/packet_sender.hpp"
#include "hal/platforms/kilobot/robot_ids.hpp"
#include "hal/wall_time.hpp"

namespace arkmesh::cli {
namespace {

using namespace hal::kilobot;
using namespace std::chrono_literals;

volatile std::sig_atomic_t interrupted = 0;

struct OhcOptions {
  std::string port;
  double seconds = 0;      // 0: what suits the command
  double settle_s = 2.5;
  std::vector<std::string> numbers;
  std::filesystem::path program;
  int rounds = 0;          // 0: until somebody stops it
  double boot_s = 3, page_ms = 165;
};

// What one command says: packets, each repeated for so long.
struct Saying {
  std::string name;
  std::vector<Packet> packets;
  std::chrono::microseconds each{0};
};

std::chrono::microseconds from_seconds(double seconds) { return std::chrono::microseconds{static_cast<std::int64_t>(seconds * 1e6)}; }

std::unique_ptr<Wire> wire_to(const std::string& port) {
  try {
    return make_wire(port);
  } catch (const PortError& error) {
    throw CLI::ValidationError("PORT", error.what());
  }
}

// One line of progress on stderr: in place on a terminal, a line each two seconds elsewhere, thirty if it says the same again.
class ProgressLine {
 public:
  ~ProgressLine() {
    if (open_) fmt::print(stderr, "\r\033[K");
  }
  void show(const std::string& text, Moment now) {
    if (now < due_ || (text == text_ && now < same_due_)) return;
    due_ = now + (terminal_ ? 200ms : 2000ms);
    same_due_ = now + (terminal_ ? 200ms : 30'000ms);
    text_ = text;
    if (terminal_) fmt::print(stderr, "\r\033[K{}", text);
    else fmt::print(stderr, "{}\n", text);
    std::fflush(stderr);
    open_ = terminal_;
  }

 private:
  bool terminal_ = isatty(STDERR_FILENO) != 0, open_ = false;
  Moment due_ = Moment::min(), same_due_ = Moment::min();
  std::string text_;
};

// An open way to a controller, in real time. Throws std::runtime_error with the line's trouble when it cannot be opened.
class Controller {
 public:
  explicit Controller(const OhcOptions& options)
      : line_(wire_to(options.port), counters_), sender_(line_, from_seconds(options.settle_s), counters_) {
    constexpr auto opening_takes_at_most = 6s;
    const Moment begun = now();
    while (!interrupted && !sender_.is_up()) {
      sender_.tend(now());
      if (!line_.is_open() && !line_.trouble().empty()) throw std::runtime_error(line_.trouble());
      if (!line_.is_open() && now() - begun > opening_takes_at_most)
        throw std::runtime_error(fmt::format("{}: no answer for {} s; is that machine on, and the address right?", options.port,
                                             std::chrono::seconds(opening_takes_at_most).count()));
      if (line_.is_open()) progress.show("the controller may be starting; waiting for it", now());
      wait();
    }
  }
  // However this ends, the controller falls silent.
  ~Controller() {
    sender_.cut_short(now());
    for (const Moment end = now() + 300ms; now() < end && sender_.is_up(); wait()) {
      sender_.tend(now());
      if (!sender_.is_ready(now())) continue;
      // on the air already, or now; what may have to go between is a stop as well
      std::ignore = sender_.send(stop_packet(), stop_spacing, now());
      return;
    }
  }
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  static Moment now() { return hal::machine_time().now(); }
  PacketSender& sender() { return sender_; }
  const SerialLine& line() const { return line_; }
  void wait() { hal::machine_time().wait_until(sender_.due(now())); }

  ProgressLine progress;

 private:
  hal::Counters counters_;
  SerialLine line_;
  PacketSender sender_;
};

// Returns the exit code.
int say(const OhcOptions& options, const Saying& saying) {
  Controller controller(options);
  PacketSender& sender = controller.sender();
  std::size_t next = 0;
  Moment begun = Controller::now();
  for (; !interrupted; controller.wait()) {
    const Moment now = Controller::now();
    sender.tend(now);
    if (!controller.line().is_open()) throw std::runtime_error(controller.line().trouble());
    if (!sender.is_ready(now)) {
      const double said_s = std::chrono::duration<double>(now - begun).count(), all_s = std::chrono::duration<double>(saying.each).count();
      if (next > 0 && saying.each >= 2s) controller.progress.show(fmt::format("{}: {:.0f} of {:.0f} s", saying.name, said_s, all_s), now);
      continue;
    }
    if (next == saying.packets.size()) {
      if (!sender.is_repeating()) return 0;
      std::ignore = sender.send(stop_packet(), stop_spacing, now);
    } else if (sender.send(saying.packets[next], saying.each, now)) {
      ++next;
      begun = now;
    }
  }
  fmt::print(stderr, "arkmesh: {} was stopped before it had been said for {:.1f} s\n", saying.name,
             std::chrono::duration<double>(saying.each).count());
  return 1;
}

int upload(const OhcOptions& options) {
  Firmware firmware = read_intel_hex(options.program);
  const std::size_t bytes = firmware.size_bytes();
  Controller controller(options);
  PacketSender& sender = controller.sender();
  FirmwareUpload upload(std::move(firmware), options.rounds > 0 ? std::optional(options.rounds) : std::nullopt,
                        {.boot_for = from_seconds(options.boot_s), .spacing = from_seconds(options.page_ms / 1000)});
  fmt::print("{}: {} bytes, {} pages, {:.1f} s a round{}\n", options.program.filename().string(), bytes, upload.pages(),
             std::chrono::duration<double>(upload.round_time()).count(),
             options.rounds > 0 ? "" : "; press Ctrl-C when every robot runs the new program");
  std::fflush(stdout);
  const Moment begun = Controller::now();
  const auto since_s = [&](Moment now) { return std::chrono::duration<double>(now - begun).count(); };
  for (; !interrupted; controller.wait()) {
    const Moment now = Controller::now();
    upload.tend(sender, now);
    if (upload.is_finished() && sender.is_ready(now)) break;
    if (!sender.is_up())
      controller.progress.show(
          controller.line().is_open() ? "the controller is starting again" : controller.line().trouble() + "; trying again", now);
    else if (upload.is_calling() || (upload.round() == 0 && upload.page() == 0))
      controller.progress.show("calling the robots to their boot loaders; they flash blue", now);
    else
      controller.progress.show(
          fmt::format("round {}, page {} of {}, {:.0f} s", upload.round() + 1, upload.page(), upload.pages(), since_s(now)), now);
  }
  fmt::print("{} of {} pages sent{}, {:.0f} s\n",
             upload.round() > 0 ? fmt::format("{} rounds", upload.round()) : fmt::format("{}", upload.page()), upload.pages(),
             interrupted ? ", stopped" : "", since_s(Controller::now()));
  return upload.round() > 0 ? 0 : 1;
}

// A number from 0 to `most`, decimal or 0x and hexadecimal.
std::uint16_t number(const std::string& text, int most, const std::string& what) {
  const bool hex = text.starts_with("0x") || text.starts_with("0X");
  const std::string_view digits = std::string_view(text).substr(hex ? 2 : 0);
  int value = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, hex ? 16 : 10);
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size() || value < 0 || value > most)
    throw CLI::ValidationError(what, fmt::format("'{}' is no number from 0 to {}", text, most));
  return static_cast<std::uint16_t>(value);
}

Packet saying_packet(std::uint8_t type, std::array<std::uint8_t, 9> data = {}) { return forward_packet(Message{data, type, 0}); }

// The bytes of a calibration message: 0 save, 1 id, 2 left, 3 right, 4 straight; id, and the duties of each.
Packet calibrate_packet(std::uint8_t mode, std::uint16_t robot = 0, std::array<std::uint8_t, 4> duties = {}) {
  return saying_packet(type_calibrate, {mode, static_cast<std::uint8_t>(robot), static_cast<std::uint8_t>(robot >> 8), duties[0], duties[1],
                                        duties[2], duties[3]});
}

Packet message_packet(const std::vector<std::string>& numbers) {
  const std::uint16_t type = number(numbers.at(0), 255, "TYPE");
  if (type > 127)
    throw CLI::ValidationError(
        "TYPE", fmt::format("{} belongs to the robots' library; programs have 0 to 127, and commands have names: run, pause, ...", type));
  if (numbers.size() > 10) throw CLI::ValidationError("BYTES", fmt::format("a message holds 9 bytes, not {}", numbers.size() - 1));
  std::array<std::uint8_t, 9> data{};
  for (std::size_t i = 1; i < numbers.size(); ++i) data[i - 1] = static_cast<std::uint8_t>(number(numbers[i], 255, "BYTES"));
  return saying_packet(static_cast<std::uint8_t>(type), data);
}

void finish(int code) {
  if (code != 0) throw CLI::RuntimeError(code);
}

void add_sayings(CLI::App& ohc, const std::shared_ptr<OhcOptions>& options) {
  // `packets` is called when the command is, so that its numbers are there
  const auto add = [&ohc, options](const std::string& name, const std::string& help, double usual_s, auto packets) {
    CLI::App* command = ohc.add_subcommand(name, help)->fallthrough();
    command->callback([options, name, usual_s, packets] {
      const std::vector<Packet> what = packets();
      finish(say(*options, {name, what, from_seconds(options->seconds > 0 ? options->seconds : usual_s)}));
    });
    return command;
  };
  const auto add_plain = [&add](const std::string& name, const std::string& help, double usual_s, std::uint8_t type) {
    add(name, help, usual_s, [type] { return std::vector{saying_packet(type)}; });
  };
  add_plain("run", "Robots run their program, from the beginning or where they were paused", 1, type_run);
  add_plain("pause", "Robots stop and flash green; `run` goes on", 1, type_wakeup);
  add_plain("reset", "Robots start anew", 1, type_reset);
  add_plain("sleep", "Robots sleep; they listen every 8 s", 1, type_sleep);
  add_plain("wake", "As pause, for longer than robots sleep", 10, type_wakeup);
  add_plain("voltage", "Robots show their battery: green, blue, yellow, red", 1, type_voltage);
  add_plain("charge", "Robots show red while they are charged", 1, type_charge);
  add("stop", "The controller falls silent", 0.04, [] { return std::vector<Packet>{stop_packet()}; });
  add("lamp", "Switches the controller's lamp on or off", 0.04, [] { return std::vector{led_toggle_packet()}; });

  const auto take = [options](CLI::App* command, const std::string& name, const std::string& help, int least, int most) {
    command->add_option(name, options->numbers, help)->required()->expected(least, most);
  };
  take(add("message", "A message of a robot program's own", 1, [options] { return std::vector{message_packet(options->numbers)}; }),
       "TYPE_AND_BYTES", "Type 0 to 127, then up to 9 bytes, decimal or 0x...", 1, 1000);
  take(add("set-uid", "Gives the id N to every robot in sight, and saves it: put one there", 1,
           [options] {
             const std::uint16_t id = number(options->numbers.at(0), 65535, "N");
             if (id > max_robot_id) fmt::print(stderr, "arkmesh: robots with ids above {} cannot be spoken to one by one\n", max_robot_id);
             return std::vector{calibrate_packet(1, id), calibrate_packet(0)};
           }),
       "N", "0 to 65535", 1, 1);
  take(add("left", "Robots turn left with this duty", 1,
           [options] {
             return std::vector{calibrate_packet(2, 0, {static_cast<std::uint8_t>(number(options->numbers.at(0), 255, "DUTY")), 0, 0, 0})};
           }),
       "DUTY", "0 to 255; good ones are 60 to 75", 1, 1);
  take(add("right", "Robots turn right with this duty", 1,
           [options] {
             return std::vector{calibrate_packet(3, 0, {0, static_cast<std::uint8_t>(number(options->numbers.at(0), 255, "DUTY")), 0, 0})};
           }),
       "DUTY", "0 to 255; good ones are 60 to 75", 1, 1);
  take(add("straight", "Robots go straight with these duties", 1,
           [options] {
             return std::vector{calibrate_packet(4, 0, {0, 0, static_cast<std::uint8_t>(number(options->numbers.at(0), 255, "LEFT")),
                                                        static_cast<std::uint8_t>(number(options->numbers.at(1), 255, "RIGHT"))})};
           }),
       "LEFT_AND_RIGHT", "Each 0 to 255; a little lower than for turning", 2, 2);
  add("save", "Robots keep the duties and the id that they were given", 1, [] { return std::vector{calibrate_packet(0)}; });
}

}  // namespace

void add_ohc_command(CLI::App& app) {
  const auto options = std::make_shared<OhcOptions>();
  CLI::App* ohc = app.add_subcommand("ohc", "Drives an overhead controller by hand");
  ohc->add_option("PORT", options->port, "A serial device such as /dev/ttyUSB0, or tcp://host:port (ser2net)")->required();
  ohc->add_option("--seconds", options->seconds, "Repeat the command for so long (usually 1, wake 10)")->check(CLI::Range(0.04, 86400.0));
  ohc->add_option("--settle", options->settle_s, "Wait so long after opening: boards that start then hear nothing before")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  ohc->require_subcommand(1);
  ohc->footer(
      "Examples:\n  arkmesh ohc /dev/ttyUSB0 run\n  arkmesh ohc /dev/ttyUSB0 message 120 0 7 --seconds 5\n  arkmesh ohc /dev/ttyUSB0 "
      "set-uid 12\n"
      "  arkmesh ohc /dev/ttyUSB0 upload build/robot.hex\n  arkmesh ohc tcp://192.168.1.20:3001 pause\n"
      "The controller is silent afterwards. Ends with 1 when it cannot be reached.");
  ohc->parse_complete_callback([] {
    std::signal(SIGINT, [](int) { interrupted = 1; });
    std::signal(SIGTERM, [](int) { interrupted = 1; });
  });
  add_sayings(*ohc, options);

  CLI::App* upload_command =
      ohc->add_subcommand("upload", "Puts a program (Intel HEX) on all robots in sight, round after round")->fallthrough();
  upload_command->add_option("PROGRAM", options->program, "The .hex file that avr-objcopy made")->required();
  upload_command->add_option("--rounds", options->rounds, "Stop after so many; else go on until Ctrl-C")->check(CLI::Range(1, 1'000'000));
  upload_command->add_option("--boot", options->boot_s, "Call the robots to their boot loaders for so many seconds; robots asleep need 10")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  upload_command->add_option("--page-ms", options->page_ms, "Start to start of pages; below 132 the controller loses some")
      ->check(CLI::Range(132.0, 10'000.0))
      ->capture_default_str();
  upload_command->footer(
      "Example:\n  arkmesh ohc /dev/ttyUSB0 upload build/robot.hex\n"
      "Robots flash blue when they wait, green at each page, and start the program when they have all of it. Nothing is heard from\n"
      "them: look at them, and press Ctrl-C when the last one has it.");
  upload_command->callback([options] { finish(upload(*options)); });
}

}  // namespace arkmesh::cli
