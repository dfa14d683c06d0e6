// A NATS server of a test, on this machine at a port that the system chooses; it goes with the test.
#pragma once

#include <doctest/doctest.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/processes/process.hpp"
#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::tests {

class NatsServerProcess {
 public:
  // `config`: what its configuration file holds beside the address.
  explicit NatsServerProcess(const std::string& config = {}) : config_(config) { start(); }

  std::uint16_t port() const { return port_; }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  void kill() { process_->kill(); }
  void pause(bool is_paused) { process_->signal(is_paused ? SIGSTOP : SIGCONT); }
  // At the same port as before.
  void start() {
    const std::filesystem::path file = folder_.path() / "server.conf";
    std::ofstream(file) << "listen: 127.0.0.1:" << (port_ == 0 ? "-1" : std::to_string(port_))
                        << "\nports_file_dir: " << folder_.path() << "\n"
                        << config_ << "\n";
    process_ = std::make_unique<Process>("/usr/sbin/nats-server", std::vector<std::string>{"-c", file.string()},
                                         folder_.path() / "log");
    REQUIRE_MESSAGE(eventually(std::chrono::seconds(300), [&] { return find_port(); }), process_->output());
  }

 private:
  // The server writes it once it listens.
  bool find_port() {
    const std::filesystem::path file = folder_.path() / ("nats-server_" + std::to_string(process_->id()) + ".ports");
    std::ifstream in(file);
    const auto ports = nlohmann::json::parse(in, nullptr, false);
    if (ports.is_discarded() || !ports.contains("nats") || ports["nats"].empty()) return false;
    const std::string url = ports["nats"][0];
    port_ = static_cast<std::uint16_t>(std::stoul(url.substr(url.rfind(':') + 1)));
    return true;
  }

  std::string config_;
  TemporaryDirectory folder_;
  std::uint16_t port_ = 0;
  std::unique_ptr<Process> process_;
};

}  // namespace arkmesh::tests
