// How long a message takes from bus to bus through two gateways, over TCP and over TLS, what that costs, and how many
// pass without loss; beside its parts in the same run: a hop of LCM and a hop of loopback TCP. Everything by turns.
// gateway_bench SECONDS ARKMESH [BOT_LCM_TUNNEL]; prints lines of names and values. With the program of libbot2 it
// compares the two for large messages instead. Run it alone: scripts/alone gateway_bench ...
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "hal/bus/bus.hpp"
#include "tests/support/processes/process.hpp"

namespace {

using namespace arkmesh;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using Latencies = std::vector<double>;  // microseconds

constexpr int first_port = 7846, ports_of_a_pair = 3, hop_port = 7852, tcp_port = 7853,
              tunnel_port = 7854;  // and two more
constexpr int rounds = 3;
constexpr int paced = 500, rare = 20;  // messages a second, for latencies

struct Load {
  std::size_t bytes;
  int cpu_rate;            // messages a second while processor time is measured
  int tcp_goal, tls_goal;  // messages a second without loss
};
constexpr Load loads[] = {{100, 10'000, 80'000, 60'000},
                          {1'000, 10'000, 80'000, 60'000},
                          {10'000, 2'000, 35'000, 25'000},
                          {100'000, 500, 6'500, 4'000}};

std::string url(int port) {
  return fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=4194304", port);
}

double percentile(Latencies& all, double part) {
  if (all.empty()) return 0;
  std::sort(all.begin(), all.end());
  return all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1))];
}

void stamp(std::vector<std::byte>& message) {
  const auto now = Clock::now().time_since_epoch().count();
  std::memcpy(message.data(), &now, sizeof now);
}

double age_us(const std::byte* message) {
  Clock::rep sent;
  std::memcpy(&sent, message, sizeof sent);
  return static_cast<double>(Clock::now().time_since_epoch().count() - sent) * 1e-3;
}

// Calls `say` so many times a second, for so long; returns how often.
std::size_t at_rate(int rate, Clock::duration length, const std::function<void()>& say) {
  std::size_t said = 0;
  const auto begin = Clock::now();
  for (auto due = begin; due < begin + length; due += std::chrono::nanoseconds(1'000'000'000 / rate)) {
    if (due > Clock::now() + 50us) std::this_thread::sleep_until(due);
    say();
    ++said;
  }
  return said;
}

struct Heard {
  Latencies us;
  std::size_t said = 0;
};

// From one bus to another, or the same.
struct Route {
  std::string from, to, channel, heard_as;
};

// The far end of a route, heard in a thread of its own.
class Ear {
 public:
  Ear(const Route& route, std::size_t size)
      : bus_(route.to), subscription_(bus_.subscribe(route.heard_as, [this, size](std::string_view, auto bytes) {
          if (bytes.size() == size) us_.push_back(age_us(bytes.data()));
          warm_ |= bytes.size() != size;
        })) {}
  // Until something that `speaker` says arrives.
  void warm_up(hal::Bus& speaker, const std::string& channel) {
    const std::vector<std::byte> first(8);
    while (!warm_) {
      speaker.publish(channel, first);
      bus_.drain(20ms);
    }
    while (bus_.drain(100ms) > 0) continue;
  }
  void begin() {
    thread_ = std::thread([this] {
      while (!over_) bus_.drain(20ms);
      while (bus_.drain(300ms) > 0) continue;
    });
  }
  Latencies end() {
    over_ = true;
    thread_.join();
    return std::move(us_);
  }

 private:
  Latencies us_;
  bool warm_ = false;
  std::atomic<bool> over_ = false;
  hal::Bus bus_;
  std::unique_ptr<hal::Bus::Subscription> subscription_;
  std::thread thread_;
};

// Says a message on all routes so many times a second.
Heard over_buses(const std::vector<Route>& routes, std::size_t size, int rate, Clock::duration length) {
  std::vector<std::unique_ptr<hal::Bus>> speakers;
  std::vector<std::unique_ptr<Ear>> ears;
  for (const Route& route : routes) {
    speakers.push_back(std::make_unique<hal::Bus>(route.from));
    ears.push_back(std::make_unique<Ear>(route, size));
    ears.back()->warm_up(*speakers.back(), route.channel);
  }
  for (const auto& ear : ears) ear->begin();
  std::vector<std::byte> message(size);
  Heard heard;
  heard.said = routes.size() * at_rate(rate, length, [&] {
                 for (std::size_t i = 0; i < routes.size(); ++i) {
                   stamp(message);
                   speakers[i]->publish(routes[i].channel, message);
                 }
               });
  for (const auto& ear : ears) {
    const Latencies us = ear->end();
    heard.us.insert(heard.us.end(), us.begin(), us.end());
  }
  return heard;
}

Heard over_lcm(std::size_t size, int rate, Clock::duration length) {
  return over_buses({{url(hop_port), url(hop_port), "hop", "hop"}}, size, rate, length);
}

// Over a TCP connection within this process.
Heard over_tcp(std::size_t size, int rate, Clock::duration length) {
  Heard heard;
  const int listening = socket(AF_INET, SOCK_STREAM, 0), speaker = socket(AF_INET, SOCK_STREAM, 0), on = 1;
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(tcp_port);
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  const auto* address = reinterpret_cast<const sockaddr*>(&here);
  if (bind(listening, address, sizeof here) || listen(listening, 1) || connect(speaker, address, sizeof here))
    std::abort();
  const int listener = accept(listening, nullptr, nullptr);
  setsockopt(speaker, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  std::thread ear([&] {
    std::vector<std::byte> message(size);
    while (recv(listener, message.data(), size, MSG_WAITALL) == static_cast<ssize_t>(size))
      heard.us.push_back(age_us(message.data()));
  });
  std::vector<std::byte> message(size);
  heard.said = at_rate(rate, length, [&] {
    stamp(message);
    for (std::size_t done = 0; done < size;) {
      const ssize_t n = send(speaker, message.data() + done, size - done, 0);
      if (n <= 0) std::abort();
      done += static_cast<std::size_t>(n);
    }
  });
  shutdown(speaker, SHUT_WR);
  ear.join();
  for (const int socket : {listening, speaker, listener}) close(socket);
  return heard;
}

// Two processes that carry a channel from one bus to another.
class Chain {
 public:
  virtual ~Chain() = default;
  // Processor time of both so far.
  virtual double cpu_s() const = 0;
  virtual Heard carry(std::size_t size, int rate, Clock::duration length) const = 0;

 protected:
  static double cpu_s(const tests::Process& process) {
    std::ifstream stat(fmt::format("/proc/{}/stat", process.id()));
    std::string skipped;
    for (int i = 0; i < 13; ++i) stat >> skipped;
    double user = 0, system = 0;
    stat >> user >> system;
    return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
  }
};

// Two gateways at work.
class Pair final : public Chain {
 public:
  Pair(const std::string& program, bool tls) : program_(program), port_(first_port + (tls ? ports_of_a_pair : 0)) {
    if (tls) make_keys();
    const std::string unlimited = "import_rate_hz = 1e6, import_bytes_per_s = 1e12";
    const std::string scheme = tls ? "tls://" : "", here = fmt::format("{}127.0.0.1:{}", scheme, port_ + 2);
    shark_ =
        start("shark", port_, fmt::format("listen = \"{}\"\npeers = [{{lab = \"roark\", {}}}]", here, unlimited), tls);
    roark_ = start("roark", port_ + 1,
                   fmt::format("peers = [{{lab = \"shark\", connect = \"{}\", {}}}]", here, unlimited), tls);
  }
  double cpu_s() const override { return Chain::cpu_s(*shark_) + Chain::cpu_s(*roark_); }
  Heard carry(std::size_t size, int rate, Clock::duration length) const override {
    return over_buses({there()}, size, rate, length);
  }
  Heard both_ways(std::size_t size, int rate, Clock::duration length) const {
    return over_buses({there(), {url(port_ + 1), url(port_), "all", "roark/all"}}, size, rate, length);
  }

 private:
  Route there() const { return {url(port_), url(port_ + 1), "all", "shark/all"}; }
  std::string keys_of(const std::string& lab) const { return (folder_.path() / ("keys_" + lab)).string(); }
  void run(std::vector<std::string> words) const {
    tests::Process process(program_, words, folder_.path() / "keys.txt");
    if (process.wait(60s) != 0) throw std::runtime_error(process.output());
  }
  void make_keys() const {
    for (const std::string lab : {"shark", "roark"}) run({"keys", "init", lab, "--keys", keys_of(lab)});
    run({"keys", "trust", keys_of("roark") + "/roark.crt", "--keys", keys_of("shark")});
    run({"keys", "trust", keys_of("shark") + "/shark.crt", "--keys", keys_of("roark")});
  }
  std::unique_ptr<tests::Process> start(const std::string& lab, int port, const std::string& gateway, bool tls) const {
    const auto file = folder_.path() / (lab + ".toml");
    std::ofstream(file) << fmt::format(
        "[lab]\nname = \"{}\"\n[bus]\nurl = \"{}\"\n[shared]\nlabs = [\"roark\", \"shark\"]\n[gateway]\n"
        "exports = []\nordered = [\"all\"]\nimports = [\"all\"]\n{}{}\n",
        lab, url(port), tls ? fmt::format("keys = \"{}\"\n", keys_of(lab)) : "", gateway);
    return std::make_unique<tests::Process>(program_, std::vector<std::string>{"gateway", file.string()},
                                            folder_.path() / (lab + ".txt"));
  }

  std::string program_;
  const int port_;  // shark's bus; then roark's, and where shark listens
  tests::TemporaryFolder folder_;
  std::unique_ptr<tests::Process> shark_, roark_;
};

// bot-lcm-tunnel between two buses of its own, over TCP.
class Tunnel final : public Chain {
 public:
  explicit Tunnel(const std::string& program) {
    const auto start = [&](int bus, std::vector<std::string> words) {
      words.insert(words.end(), {"-q", "-l", url(bus)});
      return std::make_unique<tests::Process>(program, words, folder_.path() / fmt::format("{}.txt", bus));
    };
    server_ = start(tunnel_port, {"-p", std::to_string(tunnel_port + 2)});
    std::this_thread::sleep_for(1s);
    client_ = start(tunnel_port + 1, {"-r", "all", "-s", "none", fmt::format("127.0.0.1:{}", tunnel_port + 2)});
    std::this_thread::sleep_for(1s);
  }
  double cpu_s() const override { return Chain::cpu_s(*server_) + Chain::cpu_s(*client_); }
  Heard carry(std::size_t size, int rate, Clock::duration length) const override {
    return over_buses({{url(tunnel_port), url(tunnel_port + 1), "all", "all"}}, size, rate, length);
  }

 private:
  tests::TemporaryFolder folder_;
  std::unique_ptr<tests::Process> server_, client_;
};

void add(Latencies& to, const Latencies& from) {
  to.insert(to.end(), from.begin(), from.end());
}

// The gateways over TCP, and over TLS.
using Pairs = std::array<const Pair*, 2>;

// Latency at one rate: the parts, and the whole over both kinds of links.
void print_latency(const Pairs& pairs, std::size_t size, int rate, Clock::duration length, bool both_ways) {
  Latencies tcp, lcm, whole[2];
  for (int round = 0; round < rounds; ++round) {
    add(tcp, over_tcp(size, rate, length).us);
    add(lcm, over_lcm(size, rate, length).us);
    for (const bool tls : {false, true})
      add(whole[tls],
          (both_ways ? pairs[tls]->both_ways(size, rate, length) : pairs[tls]->carry(size, rate, length)).us);
  }
  const double bound = percentile(tcp, 0.5) + 2 * percentile(lcm, 0.5);
  const double over_tcp_us = percentile(whole[0], 0.5), over_tls_us = percentile(whole[1], 0.5);
  fmt::print(
      "latency bytes {} rate {} both_ways {} tcp_us {:.1f} lcm_us {:.1f} gateways_us {:.1f} p99_us {:.1f} of_parts "
      "{:.2f} "
      "tls_us {:.1f} tls_more_us {:.1f}\n",
      size, rate, both_ways ? 1 : 0, percentile(tcp, 0.5), percentile(lcm, 0.5), over_tcp_us,
      percentile(whole[0], 0.99), over_tcp_us / bound, over_tls_us, over_tls_us - over_tcp_us);
}

void print_cpu(const Pairs& pairs, const Load& load, Clock::duration length) {
  double us[2];
  for (const bool tls : {false, true}) {
    const Pair& pair = *pairs[tls];
    const double before = pair.cpu_s();
    const Heard heard = pair.carry(load.bytes, load.cpu_rate, length * rounds);
    us[tls] = 1e6 * (pair.cpu_s() - before) / static_cast<double>(heard.said);
  }
  fmt::print("cpu bytes {} rate {} tcp_us {:.1f} tls_us {:.1f}\n", load.bytes, load.cpu_rate, us[0], us[1]);
}

// The highest of falling rates at which nothing was lost; 0 when there was none.
int sustained(const Pair& pair, std::size_t size, int goal, Clock::duration length) {
  for (const double part : {1.5, 1.2, 1.0, 0.8, 0.6, 0.45, 0.3, 0.2}) {
    const auto begin = Clock::now();
    const int rate = static_cast<int>(part * goal);
    const Heard heard = pair.carry(size, rate, length);
    const bool kept_pace =
        static_cast<double>(heard.said) > 0.98 * rate * std::chrono::duration<double>(length).count();
    if (heard.us.size() == heard.said && kept_pace && Clock::now() - begin < 2 * length + 2s) return rate;
  }
  return 0;
}

// The highest of rates that fall by a twentieth at which nothing was lost.
int sustained_finely(const Chain& chain, std::size_t size, int from, Clock::duration length) {
  for (double rate = from; rate > 500; rate *= 0.95) {
    const Heard heard = chain.carry(size, static_cast<int>(rate), length);
    const bool kept_pace =
        static_cast<double>(heard.said) > 0.98 * rate * std::chrono::duration<double>(length).count();
    if (heard.us.size() == heard.said && kept_pace) return static_cast<int>(rate);
  }
  return 0;
}

void print_beside_tunnel(const Chain& gateways, const Chain& tunnel, Clock::duration length) {
  constexpr std::size_t size = 100'000;
  constexpr int rate = 500, highest = 10'000;
  const std::array<const Chain*, 2> chains{&gateways, &tunnel};
  double cpu_us[2] = {}, p99_us[2] = {};
  std::array<std::vector<double>, 2> most;
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < chains.size(); ++i) {
      const double before = chains[i]->cpu_s();
      Heard heard = chains[i]->carry(size, rate, length);
      cpu_us[i] += 1e6 * (chains[i]->cpu_s() - before) / static_cast<double>(heard.said) / rounds;
      p99_us[i] += percentile(heard.us, 0.99) / rounds;
      most[i].push_back(sustained_finely(*chains[i], size, highest, length));
    }
  fmt::print("tunnel bytes {} gateways_cpu_us {:.0f} tunnel_cpu_us {:.0f} gateways_p99_us {:.0f} tunnel_p99_us {:.0f} ",
             size, cpu_us[0], cpu_us[1], p99_us[0], p99_us[1]);
  fmt::print("gateways_most {:.0f} tunnel_most {:.0f}\n", percentile(most[0], 0.5), percentile(most[1], 0.5));
}

void print_sustained(const Pairs& pairs, const Load& load, Clock::duration length) {
  int rates[2];
  for (const bool tls : {false, true})
    rates[tls] = sustained(*pairs[tls], load.bytes, tls ? load.tls_goal : load.tcp_goal, length);
  fmt::print("sustained bytes {} tcp {} of {} tls {} of {}\n", load.bytes, rates[0], load.tcp_goal, rates[1],
             load.tls_goal);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    fmt::print(stderr, "gateway_bench SECONDS ARKMESH [BOT_LCM_TUNNEL]\n");
    return 2;
  }
  const auto length = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::atof(argv[1])));
  const Pair over_tcp_links(argv[2], false);
  if (argc == 4) {
    print_beside_tunnel(over_tcp_links, Tunnel(argv[3]), length);
    return 0;
  }
  const Pair over_tls_links(argv[2], true);
  const Pairs pairs{&over_tcp_links, &over_tls_links};
  for (const Load& load : loads) print_latency(pairs, load.bytes, paced, length, false);
  print_latency(pairs, 100, rare, 2 * length, true);
  for (const Load& load : loads) print_cpu(pairs, load, length);
  for (const Load& load : loads) print_sustained(pairs, load, length);
}
