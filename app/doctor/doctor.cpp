#include "app/doctor/doctor.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "arkmesh/world_t.hpp"
#include "gateway/address.hpp"
#include "gateway/config.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/bus/bus.hpp"
#include "hal/bus/bus_config.hpp"
#include "hal/bus/participants.hpp"
#include "hal/bus/sender.hpp"
#include "hal/child_process.hpp"
#include "hal/handle.hpp"
#include "hal/on_loop.hpp"
#include "hal/time/loop_time.hpp"
#include "lab/operator/operator_message.hpp"

namespace arkmesh::app {
namespace {

using namespace std::chrono_literals;
using hal::Finding;
namespace fs = std::filesystem;

constexpr const char* lcm_group = "239.255.76.67";  // LCM's own default group; any would do
constexpr long wanted_buffer_bytes = 4 << 20;       // what the sample files ask for: recv_buf_size=4194304
constexpr std::uintmax_t wanted_disk_bytes = std::uintmax_t{1} << 30;

sockaddr_in address(const char* ip, std::uint16_t port) {
  sockaddr_in a{};
  a.sin_family = AF_INET;
  a.sin_port = htons(port);
  ::inet_pton(AF_INET, ip, &a.sin_addr);
  return a;
}

Finding receive_buffer() {
  const std::string file = "/proc/sys/net/core/rmem_max";
  Finding finding{"receive buffer (net.core.rmem_max)", "",
                  fmt::format("as root: sysctl -w net.core.rmem_max={}", wanted_buffer_bytes)};
  long bytes = 0;
  // Network namespaces do not show the limit; it is then that of the machine around them.
  if (std::ifstream in(file); in >> bytes && bytes < wanted_buffer_bytes)
    finding.problem = fmt::format("the kernel allows {} bytes, and LCM loses bursts of messages below {}", bytes,
                                  wanted_buffer_bytes);
  return finding;
}

// The full path of a program, or empty.
fs::path program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path ? path : "";
  while (!rest.empty()) {
    const auto end = std::min(rest.find(':'), rest.size());
    const fs::path candidate = fs::path(rest.substr(0, end)) / name;
    if (::access(candidate.c_str(), X_OK) == 0 && !fs::is_directory(candidate)) return candidate;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return {};
}

Finding needs_program(const std::string& name, const std::string& purpose, const std::string& package) {
  Finding finding{name, "", "apt-get install " + package};
  if (program(name).empty()) finding.problem = fmt::format("the program {} is missing: {}", name, purpose);
  return finding;
}

Finding plots() {
  Finding finding{"Python with matplotlib", "", "apt-get install python3 python3-matplotlib"};
  const char* ask = "import importlib.util as u, sys; sys.exit(u.find_spec('matplotlib') is None)";
  if (hal::run_to_end({.command = {"/usr/bin/python3", "-c", ask}}).status != 0)
    finding.problem = "/usr/bin/python3 with matplotlib is missing: drawing/plot draws with it";
  return finding;
}

Finding spy() {
  Finding finding{"Java for lcm-spy", "", "apt-get install default-jdk liblcm-java libjchart2d-java"};
  const fs::path java = program("java");
  std::error_code ignored;
  const fs::path home = fs::canonical(java, ignored).parent_path().parent_path();
  if (java.empty())
    finding.problem = "the program java is missing: lcm-spy needs it";
  else if (!fs::exists(home / "lib/libawt_xawt.so") && !fs::exists(home / "lib/amd64/libawt_xawt.so"))
    finding.problem = "the installed Java is headless, but lcm-spy opens windows";
  else
    for (const char* jar : {"/usr/share/java/lcm.jar", "/usr/share/java/jchart2d.jar"})
      if (!fs::exists(jar)) finding.problem = fmt::format("{} is missing: lcm-spy needs it", jar);
  return finding;
}

Finding disk() {
  std::error_code error;
  const auto here = fs::current_path(error);
  const auto space = fs::space(here, error);
  Finding finding{"free disk space", "", "delete old run folders, or give another disk with --out"};
  if (!error && space.available < wanted_disk_bytes)
    finding.problem =
        fmt::format("{} has {} MB left; recordings stop when the disk is full", here.string(), space.available >> 20);
  return finding;
}

// The lab that sent a message of one of the types that labs and gateways repeat.
std::optional<std::string> sender(std::span<const std::byte> bytes) {
  for (const std::int64_t type : {lab_status_t::getHash(), peers_t::getHash(), world_t::getHash()})
    if (const auto read = hal::read_sender(bytes, type)) return read->lab;
  return {};
}

// Who talks on a bus: labs, and labs whose gateway does.
struct Heard {
  std::set<std::string> labs, gateways;
  std::map<std::string, lab_status_t> others;  // by lab, through the own gateway
  std::set<std::string> answered;              // those of them that an operator's question reaches
};

// Listens for a second and a half; labs and gateways speak at least once a second.
Heard listen_on(hal::Bus& bus) {
  Heard heard;
  const auto hear = [&](std::string_view channel, std::span<const std::byte> bytes) {
    const auto lab = sender(bytes);
    if (lab) heard.labs.insert(*lab);
    if (lab && channel == hal::channel::peers) heard.gateways.insert(*lab);
  };
  const auto status = bus.subscribe(hal::channel::status, hear), peers = bus.subscribe(hal::channel::peers, hear),
             world = bus.subscribe(hal::channel::world, hear);
  const auto others = bus.subscribe("[^/]+/status", [&](std::string_view channel, std::span<const std::byte> bytes) {
    if (lab_status_t m; hal::read_message(bytes, m).empty())
      heard.others.insert_or_assign(std::string(channel.substr(0, channel.find('/'))), m);
  });
  const auto answers = bus.subscribe("[^/]+/" + lab::answer_channel, [&](std::string_view channel, auto) {
    heard.answered.emplace(channel.substr(0, channel.find('/')));
  });
  bus.publish(lab::operator_channel, lab::question());
  hal::EventLoop loop;
  const hal::Readable heard_any(loop, bus.descriptor(), [&] { bus.drain(); });
  hal::LoopTime time(loop);
  time.wait_until(time.now() + 1500ms);
  return heard;
}

// Whether the gateway of the lab could listen where its file says.
Finding listening(const std::string& where, bool gateway_is_running) {
  Finding finding{"TCP " + where, "", ""};
  if (const std::string why = gateway::why_not_listenable(where); !why.empty()) {
    finding.problem = "gateway.listen " + why;
    finding.remedy = "correct the key gateway.listen";
    return finding;
  }
  const auto there = gateway::read_listen_address(where).at;
  const hal::Handle socket(::socket(there.protocol().family(), SOCK_STREAM | SOCK_CLOEXEC, 0));
  const int on = 1;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(socket.get(), there.data(), static_cast<socklen_t>(there.size())) == 0 && ::listen(socket.get(), 1) == 0)
    return finding;
  if (gateway_is_running) {
    finding.what += " (in use by this lab's own gateway)";
    return finding;
  }
  finding.problem = errno == EADDRINUSE ? fmt::format("port {} is taken by another program", there.port())
                                        : fmt::format("cannot listen there: {}", std::strerror(errno));
  finding.remedy =
      fmt::format("list its user with: ss -ltnp 'sport = :{}'; or choose another port in gateway.listen", there.port());
  return finding;
}

// Which of the other labs will not obey when this lab's operator stops all, and whose STOP does not come here.
Finding stop_of_all(const hal::Participants& shared, const Heard& heard, const hal::Section& root) {
  Finding finding{"STOP of all labs", "", "docs/security.md, Operators of other labs, explains what each file needs"};
  const auto problem = [&](const std::string& text) {
    finding.problem += (finding.problem.empty() ? "" : "; ") + text;
  };
  using gateway::Direction;
  gateway::ChannelRules rules;
  try {
    rules = gateway::read_gateway_config(root.section("gateway"), shared.lab, shared.labs).rules;
  } catch (const hal::ConfigError& error) {
    finding.problem = error.what();
    return finding;
  }
  const auto givers = root.section("safety").get("commands_from", std::vector<std::string>());
  std::vector<std::string> unknown, unsent, loose, untaken;
  for (const std::string& lab : shared.labs) {
    if (lab == shared.lab) continue;
    const bool obeyed = std::ranges::count(givers, lab) + std::ranges::count(givers, "*") > 0;
    const auto is_loose = [&](const std::string& channel) {
      const auto* const rule = rules.passing(Direction::exports, channel, lab);
      return rule && rule->delivery != gateway::Delivery::ordered;
    };
    if (!rules.passing(Direction::exports, lab::operator_channel, lab)) unsent.push_back(lab);
    if (is_loose(lab::operator_channel) || (obeyed && is_loose(lab::answer_channel))) loose.push_back(lab);
    if (obeyed && !rules.passing(Direction::imports, lab::operator_channel, lab)) untaken.push_back(lab);
    if (const auto other = heard.others.find(lab); other == heard.others.end())
      unknown.push_back(lab);
    else if (std::ranges::count(other->second.obeys, shared.lab) == 0)
      problem(lab::not_obeyed(lab, shared.lab));
    else if (!heard.answered.contains(lab))
      problem(lab::not_reached(lab));
  }
  if (!unsent.empty())
    problem(
        fmt::format("no rule exports operator_command to {}, so no operator of {} is heard there; name it in "
                    "gateway.ordered",
                    fmt::join(unsent, ", "), shared.lab));
  if (!loose.empty())
    problem(
        fmt::format("operator_command or operator_answer is not \"ordered\" for {}, so a newer message can replace "
                    "a command or its answer; name operator_command in gateway.ordered only",
                    fmt::join(loose, ", ")));
  if (!untaken.empty())
    problem(
        fmt::format("no rule imports operator_command from {}, so {} does not hear their STOP; name it in "
                    "gateway.imports",
                    fmt::join(untaken, ", "), shared.lab));
  if (!unknown.empty())
    finding.what += fmt::format(" (unknown for labs that are not heard: {})", fmt::join(unknown, ", "));
  return finding;
}

}  // namespace

hal::Finding multicast() {
  const std::string route = "as root: ip link set lo up; ip route add 224.0.0.0/4 dev lo";
  Finding finding{"multicast on this machine", "", route};
  const hal::Handle in(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)),
      out(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  auto any = address("0.0.0.0", 0);
  socklen_t length = sizeof any;
  if (!in || !out || ::bind(in.get(), reinterpret_cast<sockaddr*>(&any), sizeof any) != 0 ||
      ::getsockname(in.get(), reinterpret_cast<sockaddr*>(&any), &length) != 0) {
    finding.problem = "no UDP socket can be opened";
    finding.remedy = "check the limit on open files (ulimit -n) and the sandbox, if this runs in one";
    return finding;
  }
  ip_mreq membership{};
  ::inet_pton(AF_INET, lcm_group, &membership.imr_multiaddr);
  if (::setsockopt(in.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0) {
    finding.problem = "there is no multicast route, so LCM cannot carry a lab's messages";
    return finding;
  }
  const auto group = address(lcm_group, ntohs(any.sin_port));
  const unsigned char stay_here = 0;
  ::setsockopt(out.get(), IPPROTO_IP, IP_MULTICAST_TTL, &stay_here, sizeof stay_here);
  const char greeting[] = "arkmesh doctor";
  if (::sendto(out.get(), greeting, sizeof greeting, 0, reinterpret_cast<const sockaddr*>(&group), sizeof group) < 0) {
    finding.problem = "there is no multicast route, so LCM cannot carry a lab's messages";
    return finding;
  }
  pollfd waiting{in.get(), POLLIN, 0};
  if (::poll(&waiting, 1, 1000) != 1) {
    finding.problem =
        "a multicast message sent on this machine does not come back: a firewall drops it, or the interface is down";
    finding.remedy = "let UDP to 239.0.0.0/8 pass on lo; " + route;
  }
  return finding;
}

std::vector<hal::Finding> machine() {
  return {receive_buffer(),
          needs_program("cc", "it compiles robot controllers when a run begins", "gcc libc6-dev"),
          needs_program("lcm-logger", "it records a lab's public bus", "liblcm-bin"),
          plots(),
          spy(),
          disk()};
}

std::vector<hal::Finding> lab_ports(const hal::Section& root, bool multicast_works) {
  const std::string lab = root.section("lab").get("name", std::string(), {.required = true});
  const auto [url, hear] = root.section("bus").read<hal::BusConfig>();
  const std::string listen = root.section("gateway").get("listen", std::string());
  std::vector<hal::Finding> findings;
  Heard heard;
  if (multicast_works) {
    Finding& finding = findings.emplace_back(Finding{
        "LCM port of lab " + lab, "", "give each lab on this machine a port of its own in bus.url of its file"});
    try {
      hal::Bus bus(url, hear);
      heard = listen_on(bus);
      for (const auto& other : heard.labs)
        if (other != lab) finding.problem += (finding.problem.empty() ? "" : ", ") + other;
      if (!finding.problem.empty()) finding.problem += fmt::format(": also on {}", url);
    } catch (const std::exception& error) {
      finding.problem = error.what();
    }
  }
  if (const auto shared = root.read<hal::Participants>(); shared.labs.size() > 1)
    findings.push_back(stop_of_all(shared, heard, root));
  if (!listen.empty()) findings.push_back(listening(listen, heard.gateways.contains(lab)));
  return findings;
}

}  // namespace arkmesh::app
