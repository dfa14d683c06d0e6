// `arkmesh emulator`: a testbed of simulated robots behind cameras and an overhead controller or nodes, for everything
// that wants hardware.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "emulator/emulator.hpp"
#include "emulator/emulator_record.hpp"
#include "emulator/emulator_server.hpp"
#include "hal/config/config.hpp"
#include "hal/counted.hpp"

namespace arkmesh::cli {
namespace {

struct EmulatorOptions {
  std::string file, truth, video, calibration;
  std::vector<std::string> sets;
  double seconds = 0;
  std::pair<int, std::string> chessboards;  // how many, and the folder
  bool offline = false;
};

void print_counters(const hal::Counters& counters) {
  for (const auto& [name, total] : counters.all())
    if (total > 0) fmt::print("  {:<36} {}\n", name, total);
}

// As fast as it goes: each picture and row of the truth at its exact time.
void run_offline(emulator::Emulator& emulator, emulator::EmulatorRecord& record, double seconds,
                 hal::StopRequest& stop) {
  const hal::LabTime period = emulator.config().frame_period, end{static_cast<std::int64_t>(seconds * 1e6)};
  int shown = 0;
  for (std::int64_t frame = 0; frame * period <= end && !stop.stopped(); ++frame) {
    emulator.advance_to(frame * period);
    record.add(emulator);
    if (const int tenth = static_cast<int>(10 * frame * period / std::max(end, period)); tenth > shown) {
      shown = tenth;
      fmt::print(stderr, "{:.0f} of {:.0f} s\n", static_cast<double>((frame * period).count()) * 1e-6, seconds);
    }
  }
}

void run_live(emulator::Emulator& emulator, emulator::EmulatorRecord& record, double seconds, hal::StopRequest& stop) {
  hal::EventLoop loop;
  emulator::EmulatorServer server(loop, emulator, record);
  for (std::size_t k = 0; k < emulator.cameras(); ++k)
    fmt::print("camera {}: {}\n", emulator.camera(k).settings().name, server.url(k));
  const std::string link = emulator.config().ohc_link.empty() ? "" : " (" + emulator.config().ohc_link + ")";
  if (emulator.nodes())
    fmt::print("nodes: tcp:{}:{}\n", emulator.config().listen, server.nodes_port());
  else
    fmt::print("overhead controller: tcp://{}:{} or {}{}\n", emulator.config().listen, server.ohc_port(),
               server.terminal(), link);
  fmt::print("commands: {}:{} (lines of text; `help` lists them)\n", emulator.config().listen, server.control_port());
  std::fflush(stdout);
  server.listen([&server] {
    fmt::print("overhead controller: {}\n", server.terminal().empty() ? "unplugged" : server.terminal());
    std::fflush(stdout);
  });
  const auto end = [&loop](auto error, auto...) {
    if (!error) loop.stop();
  };
  boost::asio::signal_set signals(loop, SIGINT, SIGTERM);
  signals.async_wait(end);
  boost::asio::steady_timer over(loop);
  if (seconds > 0) {
    over.expires_after(std::chrono::microseconds(static_cast<std::int64_t>(seconds * 1e6)));
    over.async_wait(end);
  }
  if (!stop.stopped()) loop.run();
  fmt::print("after {:.1f} s:\n", static_cast<double>(emulator.now().count()) * 1e-6);
  print_counters(server.counters());
}

void run(const EmulatorOptions& options) {
  OperatorStop stop;
  const hal::Config config = hal::Config::from_file(options.file, options.sets);
  if (const hal::Section root = config.root(); root.place("emulator").empty() && !root.place("lab").empty())
    throw hal::ConfigError(fmt::format(
        "{} is a lab's file; an emulator's file has a table [emulator], such as experiments/emulator/roark.toml",
        options.file));
  emulator::Emulator emulator(config.root());
  config.refuse_unknown();
  if (!options.calibration.empty()) emulator::write_calibration(emulator, options.calibration);
  if (const auto& [pictures, folder] = options.chessboards; !folder.empty()) {
    if (pictures < 1 || pictures > 1000) throw hal::ConfigError("--chessboard N FOLDER: N must be 1 to 1000");
    emulator::write_chessboards(emulator, pictures, folder);
    fmt::print("{} of a chessboard (9 x 6 inner corners, 25 mm) for each camera in {}\n",
               hal::counted(pictures, "picture"), folder);
    return;
  }
  emulator::EmulatorRecord record(emulator, options.truth, options.video);
  if (!options.offline) return run_live(emulator, record, options.seconds, stop);
  if (options.seconds <= 0) throw hal::ConfigError("--offline needs --seconds N, the duration in the emulator's time");
  run_offline(emulator, record, options.seconds, stop);
  print_counters(emulator.counters());
}

}  // namespace

void add_emulator_command(CLI::App* command) {
  auto options = std::make_shared<EmulatorOptions>();
  command->add_option("file", options->file, "The emulator's configuration file")->required()->check(CLI::ExistingFile);
  command->add_option("--set", options->sets, "Override a key: --set emulator.seed=7")->allow_extra_args(false);
  command->add_option("--seconds", options->seconds, "Duration in seconds (default: until Ctrl-C)")
      ->check(CLI::Range(0.0, 1e7));
  command->add_option("--truth", options->truth,
                      "Write true poses and LEDs to this CSV file, a row for each robot and picture");
  command->add_option("--video", options->video,
                      "Write the cameras' pictures as a video (.avi: single JPEGs, .mp4: smaller)");
  command->add_flag("--offline", options->offline, "Open no ports; run as fast as possible, for --truth and --video");
  command->add_option("--calibration", options->calibration, "Write the cameras' calibration to this file (.yaml)");
  command
      ->add_option("--chessboard", options->chessboards,
                   "Only write N pictures of a chessboard for each camera into FOLDER")
      ->type_name("N FOLDER");
  command->footer(
      "Example:\n  arkmesh emulator experiments/emulator/roark.toml --seconds 60 --truth truth.csv\n"
      "  arkmesh emulator experiments/emulator/roark.toml --offline --seconds 60 --video emulator.mp4 --truth "
      "truth.csv");
  command->callback([options] { run(*options); });
}

}  // namespace arkmesh::cli
