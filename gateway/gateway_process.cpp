#include "gateway/gateway_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gateway/address.hpp"
#include "gateway/config.hpp"
#include "gateway/federation/nats_address.hpp"
#include "gateway/gateway.hpp"
#include "gateway/links/connections.hpp"
#include "gateway/links/links.hpp"
#include "gateway/links/tls_keys.hpp"
#include "gateway/metrics.hpp"
#include "gateway/metrics_server.hpp"
#include "gateway/port_monitor.hpp"
#include "gateway/process_config.hpp"
#include "gateway/reload_door.hpp"
#include "hal/bus/bus.hpp"
#include "hal/bus/bus_config.hpp"
#include "hal/bus/loss.hpp"
#include "hal/config/without_secrets.hpp"
#include "hal/counted.hpp"
#include "hal/handle.hpp"

namespace arkmesh::gateway {
namespace {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto tick_period = 100ms;
// How long others on our LCM port have to answer before we meet any peer, and how long after that one who was here
// before ends us.
constexpr std::chrono::milliseconds answer_time{300}, start_time{6000};
// How long our TCP port may be taken: by a later gateway of this lab that is about to give way to us.
constexpr std::chrono::milliseconds port_time{5000};
// Messages taken from the bus before the sockets have their turn; together they make one write per peer.
constexpr int max_per_turn = 100;
constexpr auto say_period = 1s;  // at most one line per peer

// Grows with each start, also after a crash: peers take the newer of two gateways for the living one.
std::uint64_t new_boot_id() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
          .count());
}

bool has_terminal() {
  const hal::Handle terminal(::open("/dev/tty", O_RDONLY | O_NOCTTY | O_CLOEXEC));
  return static_cast<bool>(terminal);
}

// As `nohup` leaves it.
bool ignores_hangup() {
  struct sigaction now {};
  return ::sigaction(SIGHUP, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

class GatewayProcess {
 public:
  explicit GatewayProcess(const std::function<hal::Config()>& read) : GatewayProcess(read, read()) {}
  GatewayProcess(const std::function<hal::Config()>& read, const hal::Config& file)
      : read_(read),
        config_(read_process_config(file)),
        fixed_(fixed_keys(file)),
        boot_id_(new_boot_id()),
        bus_(config_.bus.url, config_.bus.hear),
        monitor_(bus_, config_.lab, boot_id_),
        readable_(io_, bus_.descriptor()),
        timer_(io_),
        ends_with_terminal_(has_terminal() && !ignores_hangup()),
        signals_(io_, SIGINT, SIGTERM, SIGHUP),
        door_(io_, file.file(), [this] { return reload(); }) {}
  ~GatewayProcess() { readable_.release(); }  // the descriptor is the bus's

  // Returns when it was asked to stop.
  void run() {
    await_signal();
    serve_bus();
    monitor_.ask();
    // Nobody is met before the answers are in, but who is first loses no more than that: its port is open, so that
    // peers wait there and not for their next attempt, and what its lab says meanwhile is kept for them. A port that is
    // taken may be that of somebody who has yet to answer, or of a later one who is about to give way to us.
    try_to_begin();
    begun_ = Clock::now();
    look_around();
    io_.run();
    const std::string lost = losses();
    gateway_.reset();
    say(lost.empty() ? "stopped" : fmt::format("stopped; lost or refused: {}", lost));
  }

 private:
  // By counter; what a newer message replaced was not lost.
  std::string losses() const {
    if (!gateway_) return {};
    const peers_t all = gateway_->describe(now_us(), counters());
    std::vector<std::string> out;
    const auto note = [&](const std::string& whose, const std::vector<counter_t>& counters) {
      for (const counter_t& each : counters)
        if (each.value > 0 && hal::is_loss(each.name) && each.name.find("replaced") == std::string::npos)
          out.push_back(fmt::format("{}{} {}", whose, each.name, each.value));
    };
    note("", all.counters);
    for (const peer_t& peer : all.peers) note(peer.lab + ".", peer.counters);
    return fmt::format("{}", fmt::join(out, ", "));
  }

  void await_signal() {
    signals_.async_wait([this](auto error, int signal) {
      if (error) return;
      // The kernel sends SIGHUP, too, when the terminal is closed.
      if (signal != SIGHUP || (ends_with_terminal_ && !has_terminal())) return io_.stop();
      reload();
      await_signal();
    });
  }

  // The rules of the file as it is now, without touching any link. A wrong file changes nothing. Returns what it says:
  // lines, or '!' and why it is wrong.
  std::string reload() {
    try {
      const hal::Config file = read_();
      ProcessConfig now = read_process_config(file);
      if (now.lab != config_.lab)
        throw hal::ConfigError(fmt::format("{} now belongs to lab {}", file.file().string(), now.lab));
      config_.gateway.rules = std::move(now.gateway.rules);
      if (gateway_) {
        node_->set_exports(config_.gateway.rules.announced(peer_labs()));
        gateway_->set_rules(config_.gateway.rules);
      }
      return say(fmt::format("{} in force, as {} says now",
                             hal::counted(config_.gateway.rules.all().size(), "rule is", "rules are"),
                             file.file().filename().string())) +
             say_what_waits_for_a_start(fixed_keys(file));
    } catch (const std::exception& error) {
      say(fmt::format("the rules are unchanged: {}", error.what()));
      return fmt::format("!{}", error.what());
    }
  }

  std::string say_what_waits_for_a_start(const std::map<std::string, std::string, std::less<>>& now) const {
    std::set<std::string, std::less<>> changed;
    for (const auto& [key, value] : now)
      if (const auto before = fixed_.find(key); before == fixed_.end() || before->second != value) changed.insert(key);
    for (const auto& [key, value] : fixed_)
      if (!now.contains(key)) changed.insert(key);
    if (changed.empty()) return {};
    return say(fmt::format("changed in the file, but effective only after a restart: {}", fmt::join(changed, ", ")));
  }

  std::vector<std::string> peer_labs() const {
    std::vector<std::string> labs;
    for (const PeerConfig& peer : config_.gateway.peers) labs.push_back(peer.lab);
    return labs;
  }

  // After each answer time: gives way to an earlier gateway, tries again while the port is taken, goes on once it is
  // ours.
  void look_around() {
    timer_.expires_after(answer_time);
    timer_.async_wait([this](auto error) {
      if (error) return;
      // An answer that is here has been heard: the loop turns to descriptors before timers.
      refuse_if_not_alone();
      if (monitor_.heard_other()) monitor_.ask();  // a later one that has our port has to hear that we were here before
      if (failure_) try_to_begin();
      if (failure_ && Clock::now() - begun_ >= port_time) std::rethrow_exception(failure_);
      if (failure_) return look_around();
      begun_ = Clock::now();
      gateway_->start();
      for (const PeerConfig& peer : config_.gateway.peers)
        if (!peer.connect.empty())
          say(fmt::format("connecting to {} at {}", peer.lab, hal::without_secrets(peer.connect)));
      tick();
    });
  }

  void try_to_begin() {
    failure_ = nullptr;
    try {
      begin();
    } catch (const hal::ConfigError&) {
      throw;
    } catch (const std::runtime_error&) {
      failure_ = std::current_exception();
    }
  }

  void serve_bus() {
    readable_.async_wait(asio::posix::stream_descriptor::wait_read, [this](auto error) {
      if (error) return;
      const auto drain = [this] { bus_.drain(0ms, max_per_turn); };
      if (node_)
        node_->corked(drain);
      else
        drain();
      serve_bus();
    });
  }

  void begin() {
    if (!config_.gateway.metrics.empty() && !metrics_)
      metrics_ = std::make_unique<MetricsServer>(io_, loopback_endpoint(config_.gateway.metrics), [this] {
        return gateway_ ? to_metrics(gateway_->describe(now_us(), counters())) : std::string();
      });
    TcpSettings settings;
    settings.lab = config_.lab;
    settings.experiment = config_.experiment;
    settings.boot_id = boot_id_;
    settings.exports = config_.gateway.rules.announced(peer_labs());
    settings.listen = config_.gateway.listen;
    settings.federation = config_.gateway.federation;
    settings.outbox_bytes = config_.gateway.outbox_bytes;
    settings.max_message_bytes = config_.gateway.max_message_bytes;
    settings.flow = config_.gateway.flow;
    if (config_.gateway.needs_keys() && !keys_)
      keys_ = std::make_shared<TlsKeys>(KeyFolder(config_.gateway.keys), config_.lab);
    settings.keys = keys_;
    settings.notice = [this](const std::string& sentence) { notice_ = sentence; };
    node_ = std::make_unique<Connections>(io_, std::move(settings));

    std::vector<std::unique_ptr<Link>> links;
    for (const PeerConfig& peer : config_.gateway.peers)
      links.push_back(make_link({io_, *node_, config_.lab, boot_id_, config_.gateway}, peer));
    gateway_ = std::make_unique<Gateway>(bus_, config_.lab, boot_id_, config_.gateway.rules, std::move(links));

    if (config_.gateway.is_federated() && !config_.gateway.watched.empty()) {
      std::string pattern;
      for (const std::string& each : config_.gateway.watched)
        pattern += (pattern.empty() ? "" : "|") + lcm_pattern(each);
      watched_ = bus_.subscribe(pattern, [this](auto channel, auto bytes) { node_->watch(channel, bytes); });
    }

    for (const std::string& lab : config_.gateway.ignored)
      say(fmt::format("lab {} does not take part: shared.labs does not list it", lab));
    if (!config_.gateway.listen.empty())
      say(fmt::format("listening on {}{}", is_tls(config_.gateway.listen) ? tls_scheme : "",
                      to_text(node_->listening())));
    for (const auto& link : gateway_->links()) said_[link->peer()] = {link->stats().why, {}};
  }

  void tick() {
    if (Clock::now() - begun_ < start_time) refuse_if_not_alone();
    if (monitor_.heard_other()) gateway_->announce();
    gateway_->tick(now_us(), counters());
    say_changes();
    timer_.expires_after(tick_period);
    timer_.async_wait([this](auto error) {
      if (!error) tick();
    });
  }

  static std::chrono::microseconds now_us() {
    return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch());
  }

  // What belongs to no peer.
  hal::Counters counters() const {
    hal::Counters all = node_->counters();
    all.merge(monitor_.counters());
    if (metrics_) all.merge(metrics_->counters());
    return all;
  }

  // Whoever came later gives way, so that a lab at work is not disturbed.
  void refuse_if_not_alone() const {
    if (!monitor_.earlier().empty()) throw hal::ConfigError(monitor_.earlier());
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
      const LinkStats stats = link->stats();
      say_change(link->peer(), stats.why,
                 stats.up ? fmt::format("{} {}", link->peer(), stats.why)
                          : fmt::format("{} not connected: {}", link->peer(), stats.why));
    }
    if (keys_) say_about_keys(say_change);
    if (!notice_.empty()) say_change("", notice_, notice_);
    if (!monitor_.earlier().empty()) say_change("bus", monitor_.earlier(), monitor_.earlier());
  }

  template <class SayChange>
  void say_about_keys(const SayChange& say_change) const {
    const auto say_end = [&](const std::string& lab) {
      const auto days = keys_->days_left(lab);
      if (!days) return;
      const std::string when = *days < 0 ? "has ended" : fmt::format("ends in {} days", *days);
      say_change("certificate " + lab, when,
                 fmt::format("the certificate of lab {} {}; extend it there: arkmesh keys renew {}", lab, when, lab));
    };
    say_end(config_.lab);
    for (const auto& link : gateway_->links()) say_end(link->peer());
    std::string wrong;
    for (const std::string& sentence : keys_->errors()) wrong += (wrong.empty() ? "" : "; ") + sentence;
    if (!wrong.empty()) say_change("keys", wrong, "keys: " + wrong);
  }

  // To standard output, at once. Nobody may be reading it any more; that is no reason to stop. Returns the line.
  std::string say(std::string_view sentence) const {
    std::string line = fmt::format("gateway of {}: {}\n", config_.lab, sentence);
    std::fwrite(line.data(), 1, line.size(), stdout);
    std::fflush(stdout);
    return line;
  }

  std::function<hal::Config()> read_;
  ProcessConfig config_;  // of the start, but for the rules
  const std::map<std::string, std::string, std::less<>> fixed_;
  std::exception_ptr failure_;  // why it could not begin yet
  std::uint64_t boot_id_;
  asio::io_context io_{1};
  hal::Bus bus_;
  PortMonitor monitor_;
  asio::posix::stream_descriptor readable_;
  asio::steady_timer timer_;
  const bool ends_with_terminal_;
  asio::signal_set signals_;
  ReloadDoor door_;
  std::shared_ptr<TlsKeys> keys_;  // null where nothing is TLS
  std::unique_ptr<Connections> node_;
  std::unique_ptr<Gateway> gateway_;  // holds the node's links
  std::unique_ptr<hal::Bus::Subscription> watched_;
  std::unique_ptr<MetricsServer> metrics_;  // null: nobody asked for it
  Clock::time_point begun_;                 // to connect to peers
  std::map<std::string, Said> said_;        // by peer, "" for strangers, "bus" for the LCM port
  std::string notice_;
};

}  // namespace

void run_gateway(const std::function<hal::Config()>& read) {
  GatewayProcess(read).run();
}

void check_gateway_file(const hal::Config& config) {
  read_process_config(config);
}

}  // namespace arkmesh::gateway
