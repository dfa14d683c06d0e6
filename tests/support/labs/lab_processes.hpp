// Real lab and gateway processes on loopback: every lab with its own LCM port, gateway and run folder, watched through
// its bus.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hal/bus/bus.hpp"
#include "tests/support/processes/process.hpp"

namespace arkmesh::tests {

class LabProcesses {
 public:
  struct Options {
    std::vector<std::string> labs = {"shark", "roark"};
    std::vector<std::string> overrides;                      // of every lab and gateway
    std::map<std::string, std::vector<std::string>> by_lab;  // of one lab and its gateway
    // Where lab a's gateway is told to find lab b; the default is b's own listening port. For a proxy between them.
    std::map<std::pair<std::string, std::string>, int> through_port;
    int first_port = 7900;  // LCM and TCP ports from here on, one each per lab
  };

  explicit LabProcesses(Options options);

  // Gateways first, then labs.
  void start();
  void start_lab(const std::string& lab);
  void start_gateway(const std::string& lab);
  Process& lab(const std::string& lab) { return *labs_.at(lab).process; }
  Process& gateway(const std::string& lab) { return *labs_.at(lab).gateway; }
  int tcp_port(const std::string& lab) const { return labs_.at(lab).tcp_port; }
  std::string bus_url(const std::string& lab) const;
  std::filesystem::path directory(const std::string& lab) const { return folder_.path() / lab; }
  std::string gateway_output(const std::string& lab) const {
    return read_file(folder_.path() / (lab + "-gateway.txt"));
  }
  std::string lab_output(const std::string& lab) const { return read_file(folder_.path() / (lab + "-lab.txt")); }

  // Newest period that the lab has published, -1 before the first. Serves all buses for up to `wait`.
  std::int64_t period(const std::string& lab, std::chrono::milliseconds wait = std::chrono::milliseconds(2));
  // Waits until the lab has published `period`; false when the deadline passed first.
  bool reached(const std::string& lab, std::int64_t period, std::chrono::seconds deadline);
  // Waits until every lab process has ended; false when the deadline passed first.
  bool ended(std::chrono::seconds deadline);
  // A text of the lab's result.json, for example "final_hash"; empty when there is none.
  std::string result(const std::string& lab, const std::string& key) const;

 private:
  struct Member {
    int lcm_port = 0, tcp_port = 0;
    std::unique_ptr<Process> process, gateway;
    std::unique_ptr<hal::Bus> bus;
    std::unique_ptr<hal::Bus::Subscription> subscription;
    std::int64_t period = -1;
  };
  std::vector<std::string> arguments(const std::string& command, const std::string& lab) const;

  Options options_;
  TemporaryFolder folder_;
  std::map<std::string, Member> labs_;
};

}  // namespace arkmesh::tests
