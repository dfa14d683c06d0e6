// `arkmesh gateway`: joins a lab's LCM bus with other labs. One thread, one loop: sockets, the bus by its descriptor, a
// timer.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "gateway/address.hpp"
#include "gateway/config.hpp"
#include "gateway/gateway.hpp"
#include "gateway/links.hpp"
#include "gateway/port_watch.hpp"
#include "gateway/tcp_node.hpp"
#include "hal/bus.hpp"
#include "hal/config.hpp"
#include "hal/messages.hpp"

namespace arkmesh::cli {
namespace {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto tick_period = 100ms;
// How long others on our LCM port have to answer before we begin, and how long after that one who was here before ends
// us.
constexpr std::chrono::milliseconds answer_time{300}, start_time{3000};
// Messages taken from the bus before the sockets have their turn; together they make one write per peer.
constexpr int most_per_turn = 100;
constexpr auto say_period = 1s;  // at most one line per peer

struct Options {
  std::string file;
  std::vector<std::string> sets;
};

struct Setup {
  std::string lab, bus_url;
  gateway::GatewayConfig gateway;
};

// Reads what a gateway needs of a lab's file; the other tables are the lab's.
Setup read_setup(const Options& options) {
  const hal::Config config = hal::Config::from_file(options.file, options.sets);
  const hal::Section root = config.root();
  Setup setup;
  setup.lab = root.section("lab").required_text("name");
  if (!hal::is_lab_name(setup.lab))
    root.section("lab").refuse("name", fmt::format("must have 1 to {} of a-z, 0-9, '_' and '-'", hal::max_lab_name));
  const std::vector<std::string> labs = root.section("shared").texts("labs", {setup.lab});
  if (std::ranges::find(labs, setup.lab) == labs.end())
    root.section("shared").refuse("labs",
                                  fmt::format("does not name this lab, '{}'; add it or correct lab.name", setup.lab));
  setup.bus_url = root.section("bus").text("url", "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304");
  if (!setup.bus_url.starts_with("udpm://"))
    root.section("bus").refuse("url", "must be udpm://ADDRESS:PORT?ttl=0, for example udpm://239.255.76.67:7701?ttl=0");
  setup.gateway = gateway::read_gateway_config(root.section("gateway"), setup.lab, labs);
  config.refuse_unknown("gateway");
  for (const std::string& lab : labs)
    if (lab != setup.lab &&
        std::ranges::find(setup.gateway.peers, lab, &gateway::PeerConfig::lab) == setup.gateway.peers.end())
      root.section("gateway").refuse("peers",
                                     fmt::format("has no entry for lab {}, which shared.labs names; add one", lab));
  return setup;
}

// Grows with each start, also after a crash: peers take the newer of two gateways for the living one.
std::uint64_t new_boot_id() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
          .count());
}

class GatewayProcess {
 public:
  explicit GatewayProcess(Setup setup)
      : setup_(std::move(setup)),
        boot_id_(new_boot_id()),
        bus_(setup_.bus_url),
        watch_(bus_, setup_.lab, boot_id_),
        readable_(io_, bus_.descriptor()),
        timer_(io_),
        signals_(io_, SIGINT, SIGTERM) {}
  ~GatewayProcess() { readable_.release(); }  // the descriptor is LCM's

  // Returns when it was asked to stop.
  void run() {
    signals_.async_wait([this](auto error, int) {
      if (!error) io_.stop();
    });
    serve_bus();
    watch_.ask();
    timer_.expires_after(answer_time);
    timer_.async_wait([this](auto error) {
      if (error) return;
      refuse_if_not_alone();
      begin();
      tick();
    });
    io_.run();
    gateway_.reset();
    say("stopped");
  }

 private:
  void serve_bus() {
    readable_.async_wait(asio::posix::stream_descriptor::wait_read, [this](auto error) {
      if (error) return;
      bus_.drain(0ms, most_per_turn);
      serve_bus();
    });
  }

  void begin() {
    gateway::TcpSettings settings;
    settings.lab = setup_.lab;
    settings.boot_id = boot_id_;
    for (const gateway::Rule& rule : setup_.gateway.exports)
      settings.exports.push_back(gateway::exported(rule.channel));
    settings.listen = setup_.gateway.listen;
    settings.outbox_bytes = setup_.gateway.outbox_bytes;
    settings.max_message_bytes = setup_.gateway.max_message_bytes;
    settings.notice = [this](const std::string& sentence) { notice_ = sentence; };
    node_ = std::make_unique<gateway::TcpNode>(io_, std::move(settings));

    std::vector<std::unique_ptr<gateway::Link>> links;
    for (const gateway::PeerConfig& peer : setup_.gateway.peers)
      links.push_back(gateway::make_link({io_, *node_, setup_.lab, boot_id_, setup_.gateway}, peer));
    gateway_ = std::make_unique<gateway::Gateway>(bus_, setup_.lab, boot_id_, setup_.gateway.exports, std::move(links));
    begun_ = Clock::now();

    for (const std::string& lab : setup_.gateway.ignored)
      say(fmt::format("lab {} takes no part: it is not in shared.labs", lab));
    if (!setup_.gateway.listen.empty()) say(fmt::format("listening on {}", gateway::to_text(node_->listening())));
    for (const gateway::PeerConfig& peer : setup_.gateway.peers)
      if (!peer.connect.empty()) say(fmt::format("connecting to {} at {}", peer.lab, peer.connect));
    for (const auto& link : gateway_->links()) said_[link->peer()] = {link->stats().why, {}};
  }

  void tick() {
    if (Clock::now() - begun_ < start_time) refuse_if_not_alone();
    if (watch_.heard_other()) gateway_->announce();
    hal::Counters all = node_->counters();
    all.merge(watch_.counters());
    gateway_->tick(std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch()), all);
    say_changes();
    timer_.expires_after(tick_period);
    timer_.async_wait([this](auto error) {
      if (!error) tick();
    });
  }

  // Whoever came later gives way, so that a lab at work is not disturbed.
  void refuse_if_not_alone() const {
    if (!watch_.earlier().empty()) throw hal::ConfigError(watch_.earlier());
  }

  struct Said {
    std::string text;
    Clock::time_point when;
  };

  // The state of each peer when it has changed; of quick changes the last.
  void say_changes() {
    const auto now = Clock::now();
    const auto say_change = [&](const std::string& about, const std::string& state, const std::string& sentence) {
      Said& last = said_[about];
      if (last.text == state || now - last.when < say_period) return;
      say(sentence);
      last = {state, now};
    };
    for (const auto& link : gateway_->links()) {
      const gateway::LinkStats stats = link->stats();
      say_change(link->peer(), stats.why,
                 stats.up ? fmt::format("{} connected", link->peer())
                          : fmt::format("{} not connected: {}", link->peer(), stats.why));
    }
    if (!notice_.empty()) say_change("", notice_, notice_);
    if (!watch_.earlier().empty()) say_change("bus", watch_.earlier(), watch_.earlier());
  }

  // To standard output, at once. Nobody may be reading it any more; that is no reason to stop.
  void say(std::string_view sentence) const {
    const std::string line = fmt::format("gateway of {}: {}\n", setup_.lab, sentence);
    std::fwrite(line.data(), 1, line.size(), stdout);
    std::fflush(stdout);
  }

  Setup setup_;
  std::uint64_t boot_id_;
  asio::io_context io_{1};
  hal::Bus bus_;
  gateway::PortWatch watch_;
  asio::posix::stream_descriptor readable_;
  asio::steady_timer timer_;
  asio::signal_set signals_;
  std::unique_ptr<gateway::TcpNode> node_;
  std::unique_ptr<gateway::Gateway> gateway_;  // holds the node's links
  Clock::time_point begun_;
  std::map<std::string, Said> said_;  // by peer, "" for strangers, "bus" for the LCM port
  std::string notice_;
};

}  // namespace

void add_gateway_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("gateway", "Join a lab's LCM bus with the other labs, over TCP");
  command->add_option("file", options->file, "The lab's configuration file, the same as for `arkmesh lab`")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--set", options->sets, "Override a key: --set gateway.listen=127.0.0.1:7901")
      ->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh lab experiments/dhtf/shark.toml &\n  arkmesh gateway experiments/dhtf/shark.toml\n"
      "Ends with SIGINT or SIGTERM.");
  command->callback([options] { GatewayProcess(read_setup(*options)).run(); });
}

}  // namespace arkmesh::cli
