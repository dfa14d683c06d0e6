// What the subcommands of `arkmesh ohc` share.
#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hal/platforms/kilobot/byte_stream.hpp"
#include "hal/platforms/kilobot/ohc_packets.hpp"

namespace arkmesh::cli {

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

inline std::chrono::microseconds from_seconds(double seconds) {
  return std::chrono::microseconds{static_cast<std::int64_t>(seconds * 1e6)};
}

// Runs the work of a command, which returns false when it was stopped. What it says of the command line becomes
// CLI11's.
template <class Work>
void run_ohc(Work work) {
  try {
    if (!work()) throw CLI::RuntimeError(1);
  } catch (const hal::kilobot::WrongWord& wrong) {
    throw CLI::ValidationError(wrong.name(), wrong.what());
  } catch (const hal::kilobot::PortError& wrong) {
    throw CLI::ValidationError("PORT", wrong.what());
  }
}

void add_ohc_upload_command(CLI::App& ohc, const std::shared_ptr<OhcOptions>& options);

}  // namespace arkmesh::cli
