// `arkmesh ohc PORT upload`: puts a program on all robots.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "cli/ohc_options.hpp"
#include "cli/operator_stop.hpp"
#include "cli/progress_line.hpp"
#include "hal/platforms/kilobot/intel_hex.hpp"
#include "hal/platforms/kilobot/ohc_session.hpp"

namespace arkmesh::cli {
namespace {

using namespace hal::kilobot;

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
  fmt::print("{}: {} bytes, {} pages, {:.1f} s a round{}\n", options.program.filename().string(), bytes, upload.pages(),
             std::chrono::duration<double>(upload.round_time()).count(),
             rounds ? "" : "; press Ctrl-C when every robot runs the new program");
  std::fflush(stdout);
  const auto begun = std::chrono::steady_clock::now();
  session.upload(upload);
  const std::string sent = upload.round() == 0   ? fmt::format("{}", upload.page())
                           : upload.round() == 1 ? "1 round"
                                                 : fmt::format("{} rounds", upload.round());
  fmt::print("{} of {} pages sent{}, {:.0f} s\n", sent, upload.pages(), stop.stopped() ? ", stopped" : "",
             std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
  return upload.round() > 0;
}

}  // namespace

void add_ohc_upload_command(CLI::App& ohc, const std::shared_ptr<OhcOptions>& options) {
  CLI::App* command =
      ohc.add_subcommand("upload", "Loads a program (Intel HEX) onto all robots in reach, round after round")
          ->fallthrough();
  command->add_option("PROGRAM", options->program, "The .hex file that avr-objcopy made")->required();
  command->add_option("--rounds", options->rounds, "Stop after so many rounds (default: go on until Ctrl-C)")
      ->check(CLI::Range(1, 1'000'000));
  command
      ->add_option("--boot", options->boot_s,
                   "Call the robots to their boot loaders for so many seconds; sleeping robots need 10")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  command->add_option("--page-ms", options->page_ms, "Start to start of pages; below 132 the controller loses some")
      ->check(CLI::Range(132.0, 10'000.0))
      ->capture_default_str();
  command->footer(
      "Example:\n  arkmesh ohc /dev/ttyUSB0 upload build/robot.hex\n"
      "Robots flash blue when they wait, green at each page, and start the program when they have all of it. They\n"
      "send nothing back: watch them, and press Ctrl-C when the last one has the program. Ends with 1\n"
      "when not even one round was sent.");
  command->callback([options] { run_ohc([&] { return upload(*options); }); });
}

}  // namespace arkmesh::cli
