// `arkmesh reload`: makes gateways that run read their rules again. By SIGHUP: the kernel lets nobody send it but the
// gateway's own user.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "gateway/gateway_process.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

struct RunningGateway {
  pid_t process = 0;
  std::vector<std::string> sets;
};

// What a command line `... gateway FILE --set KEY=VALUE ...` says; nothing when it is another one.
std::optional<RunningGateway> read_command_line(const fs::path& process, const fs::path& file) {
  std::ifstream in(process / "cmdline", std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  std::vector<std::string> words;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\0', at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  if (words.size() < 3 || words[1] != "gateway") return {};
  RunningGateway out;
  bool is_it = false;
  std::error_code error;
  for (std::size_t i = 2; i < words.size(); ++i) {
    if (words[i] == "--set" && i + 1 < words.size())
      out.sets.push_back(words[++i]);
    else if (words[i].starts_with("--set="))
      out.sets.push_back(words[i].substr(6));
    else
      is_it |= fs::equivalent(fs::read_symlink(process / "cwd", error) / words[i], file, error);
  }
  if (!is_it) return {};
  return out;
}

// Whether SIGHUP would not end it: it may have begun a moment ago, or be of a version that does not know it.
bool awaits_hangup(pid_t process) {
  std::ifstream status(fmt::format("/proc/{}/status", process));
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("SigCgt:")) return (std::stoull(line.substr(7), nullptr, 16) >> (SIGHUP - 1) & 1) != 0;
  return false;
}

// Those of this file, of this program or arkmesh-gateway.
std::vector<RunningGateway> find_gateways(const fs::path& file) {
  std::vector<RunningGateway> found;
  std::error_code error;
  const fs::path own = fs::read_symlink("/proc/self/exe");
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    pid_t process = 0;
    if (const auto read = std::from_chars(name.data(), name.data() + name.size(), process);
        read.ec != std::errc() || read.ptr != name.data() + name.size())
      continue;
    const fs::path program = fs::read_symlink(entry.path() / "exe", error);
    if (error || (program != own && !program.filename().string().starts_with(gateway_program))) continue;
    auto gateway = read_command_line(entry.path(), file);
    if (!gateway) continue;
    gateway->process = process;
    found.push_back(std::move(*gateway));
  }
  return found;
}

void reload(const std::string& file) {
  const std::vector<RunningGateway> running = find_gateways(file);
  // A wrong file is said here, and not only where the gateway speaks.
  if (running.empty()) {
    gateway::check_gateway_file(hal::Config::from_file(file));
    throw std::runtime_error(
        fmt::format("no gateway of yours runs with {}; start it with: arkmesh gateway {}", file, file));
  }
  for (const RunningGateway& each : running) {
    const std::string lab = gateway::check_gateway_file(hal::Config::from_file(file, each.sets));
    if (!awaits_hangup(each.process))
      throw std::runtime_error(
          fmt::format("process {}, the gateway of {}, is only starting, or is of an older arkmesh; try again, or start "
                      "it anew",
                      each.process, lab));
    if (::kill(each.process, SIGHUP) != 0)
      throw std::runtime_error(
          fmt::format("process {}, the gateway of {}, cannot be told: {}", each.process, lab, std::strerror(errno)));
    fmt::print("gateway of {} (process {}) takes the rules of {}\n", lab, each.process, file);
  }
}

}  // namespace

void add_reload_command(CLI::App* command) {
  const auto files = std::make_shared<std::vector<std::string>>();
  command->add_option("file", *files, "The labs' configuration files, as their gateways were started with")
      ->required()
      ->check(CLI::ExistingFile);
  command->footer(
      "Example:\n  arkmesh reload experiments/dhtf/shark.toml\n"
      "What a gateway cannot change while it runs, such as an address, its output names.\n"
      "Exit codes: 0 asked, 1 no gateway runs with the file, 2 wrong command line or file.");
  command->callback([files] {
    for (const std::string& file : *files) reload(file);
  });
}

}  // namespace arkmesh::cli
