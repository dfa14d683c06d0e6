#include "tests/support/labs/lab_processes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "lab/exchange/world_message.hpp"
#include "tests/support/labs/dhtf_configs.hpp"

namespace arkmesh::tests {

LabProcesses::LabProcesses(Options options) : options_(std::move(options)) {
  int port = options_.first_port;
  for (const std::string& name : options_.labs) {
    Member& m = labs_[name];
    m.lcm_port = port++;
    m.tcp_port = port++;
    m.bus = std::make_unique<hal::Bus>(bus_url(name));
    m.subscription = m.bus->subscribe("world", [&m](std::string_view, std::span<const std::byte> bytes) {
      lab::WorldMessage message;
      if (lab::decode_world(bytes, message).empty() && !message.window.empty())
        m.period = std::max<std::int64_t>(m.period, message.window.back().period);
    });
  }
}

std::string LabProcesses::bus_url(const std::string& lab) const {
  return fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=4194304", labs_.at(lab).lcm_port);
}

std::vector<std::string> LabProcesses::arguments(const std::string& command, const std::string& lab) const {
  std::vector<std::string> names, peers;
  // Of each pair, the lab named first in `labs` listens.
  bool listens = false;
  for (const std::string& other : options_.labs) {
    names.push_back(fmt::format("\"{}\"", other));
    if (other == lab) {
      listens = true;
    } else if (listens) {
      peers.push_back(fmt::format("{{lab=\"{}\"}}", other));
    } else {
      const auto through = options_.through_port.find({lab, other});
      peers.push_back(fmt::format("{{lab=\"{}\",connect=\"127.0.0.1:{}\"}}", other,
                                  through == options_.through_port.end() ? labs_.at(other).tcp_port : through->second));
    }
  }
  std::vector<std::string> sets = {fmt::format("shared.labs=[{}]", fmt::join(names, ",")),
                                   fmt::format("bus.url=\"{}\"", bus_url(lab)),
                                   fmt::format("gateway.listen=\"127.0.0.1:{}\"", labs_.at(lab).tcp_port),
                                   fmt::format("gateway.peers=[{}]", fmt::join(peers, ","))};
  sets.insert(sets.end(), options_.overrides.begin(), options_.overrides.end());
  if (const auto own = options_.by_lab.find(lab); own != options_.by_lab.end())
    sets.insert(sets.end(), own->second.begin(), own->second.end());
  std::vector<std::string> arguments = {command, (experiments() / "dhtf" / (lab + ".toml")).string()};
  for (const std::string& set : sets) arguments.insert(arguments.end(), {"--set", set});
  return arguments;
}

void LabProcesses::start_lab(const std::string& lab) {
  std::vector<std::string> all = arguments("lab", lab);
  all.insert(all.end(), {"--force", "--out", directory(lab).string()});
  labs_.at(lab).process = std::make_unique<Process>(ARKMESH_PROGRAM, all, folder_.path() / (lab + "-lab.txt"));
}

void LabProcesses::start_gateway(const std::string& lab) {
  labs_.at(lab).gateway =
      std::make_unique<Process>(ARKMESH_PROGRAM, arguments("gateway", lab), folder_.path() / (lab + "-gateway.txt"));
}

void LabProcesses::start() {
  for (const std::string& lab : options_.labs) start_gateway(lab);
  for (const std::string& lab : options_.labs) start_lab(lab);
}

std::int64_t LabProcesses::period(const std::string& lab, std::chrono::milliseconds wait) {
  for (auto& [name, m] : labs_) m.bus->drain(name == lab ? wait : std::chrono::milliseconds(0));
  return labs_.at(lab).period;
}

bool LabProcesses::reached(const std::string& lab, std::int64_t wanted, std::chrono::seconds deadline) {
  return eventually(deadline, [&] { return period(lab) >= wanted || !this->lab(lab).running(); }) &&
         period(lab) >= wanted;
}

bool LabProcesses::ended(std::chrono::seconds deadline) {
  return eventually(deadline, [&] {
    bool running = false;
    for (auto& [name, m] : labs_)
      running = running || (m.process && m.process->running()), m.bus->drain(std::chrono::milliseconds(2));
    return !running;
  });
}

std::string LabProcesses::result(const std::string& lab, const std::string& key) const {
  std::ifstream in(directory(lab) / "result.json");
  const nlohmann::json json = nlohmann::json::parse(in, nullptr, false);
  if (json.is_discarded() || !json.contains(key)) return {};
  return json.at(key).is_string() ? json.at(key).get<std::string>() : json.at(key).dump();
}

}  // namespace arkmesh::tests
