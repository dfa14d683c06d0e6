// On a network LCM sends, and opens no socket that hears, because it is never asked to receive. In memory messages
// stand one behind the other until a drain(), without LCM, which makes two system calls for each. Exceptions of
// handlers are kept and thrown again by drain(), and a subscription that dies inside a handler is taken out only after
// its message.
#include "hal/bus/bus.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <glib.h>
#include <lcm/lcm.h>
#include <netinet/in.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "hal/bus/multicast_receiver.hpp"
#include "hal/bus/multicast_url.hpp"
#include "hal/text_map.hpp"

namespace arkmesh::hal {

namespace {

constexpr std::string_view memory_scheme = "memq://";
constexpr std::string_view self_test_channel = "LCM_SELF_TEST";  // LCM's own
constexpr std::size_t max_routes = 10'000;                       // others choose the names that come in

// Before a message in memory.
struct HeaderInMemory {
  std::uint32_t channel_bytes = 0, data_bytes = 0;
};

// Whether this machine can send to that multicast group.
bool has_route(const sockaddr_in& group) {
  const Handle probe(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!probe || connect(probe.get(), reinterpret_cast<const sockaddr*>(&group), sizeof group) == 0) return true;
  return errno != ENETUNREACH && errno != EHOSTUNREACH && errno != ENETDOWN;
}

[[noreturn]] void throw_no_route(const std::string& url) {
  throw std::runtime_error(fmt::format(
      "bus {}: this machine has no multicast route; make one with: ip link set lo up; ip route add 224.0.0.0/4 dev lo",
      url));
}

}  // namespace

struct Bus::State {
  // One subscription. Lives until the bus has let go of it.
  struct Node {
    State* bus = nullptr;             // null when the bus is gone
    std::shared_ptr<GRegex> pattern;  // what it hears, anchored
    bool cancelled = false;
    Handler handler;
  };
  using Route = std::vector<std::shared_ptr<Node>>;  // who hears a channel, in the order of subscription

  class Handle final : public Subscription {
   public:
    explicit Handle(std::shared_ptr<Node> node) : node_(std::move(node)) {}
    ~Handle() override {
      if (node_->bus) node_->bus->cancel(node_);
    }

   private:
    std::shared_ptr<Node> node_;  // shared with the bus: either may die first
  };

  lcm_t* lcm = nullptr;  // network only
  bool in_memory = false;
  std::vector<std::uint32_t> hear;               // network only: hosts, in network order
  std::unique_ptr<MulticastReceiver> receiver;   // network only, once somebody listens
  TextMap<std::shared_ptr<const Route>> routes;  // of the names heard or published so far
  std::vector<std::byte> waiting, in_hand;       // memq only: messages that were published; those that are handed out
  std::vector<std::byte> unheard;                // memq only: what stood behind a message whose handler failed
  bool dispatching = false;
  bool delivered = false;  // a handler ran for the message in hand
  std::exception_ptr failure;
  std::vector<std::shared_ptr<Node>> nodes;
  std::vector<std::shared_ptr<Node>> cancelled;  // to be taken out after the message in hand

  ~State() {
    for (const auto& node : nodes) node->bus = nullptr;
    if (lcm) lcm_destroy(lcm);
  }

  void hand_to(Node& node, std::string_view channel, std::span<const std::byte> bytes) {
    if (node.cancelled) return;
    delivered = true;
    try {
      node.handler(channel, bytes);
    } catch (...) {
      if (!failure) failure = std::current_exception();
    }
  }

  void cancel(const std::shared_ptr<Node>& node) {
    node->cancelled = true;
    if (dispatching)
      cancelled.push_back(node);
    else
      take_out(node);
  }

  void take_out(const std::shared_ptr<Node>& node) {
    routes.clear();
    node->bus = nullptr;
    std::erase(nodes, node);
  }

  // Good until somebody subscribes or a subscription dies.
  const std::shared_ptr<const Route>& route_of(std::string_view channel) {
    if (const auto it = routes.find(channel); it != routes.end()) return it->second;
    if (routes.size() >= max_routes) routes.clear();
    Route route;
    for (const auto& node : nodes)
      if (g_regex_match_full(node->pattern.get(), channel.data(), static_cast<gssize>(channel.size()), 0,
                             GRegexMatchFlags{}, nullptr, nullptr))
        route.push_back(node);
    return routes.emplace(channel, std::make_shared<const Route>(std::move(route))).first->second;
  }

  // Hands one message to all who hear it. True when a handler of ours ran.
  bool handle(std::string_view channel, std::span<const std::byte> bytes) {
    const auto route = route_of(channel);  // a copy: a handler may change the routes
    if (route->empty()) return false;
    assert(!dispatching && "a handler may not drain its own bus");
    dispatching = true;
    delivered = false;
    for (const auto& node : *route) hand_to(*node, channel, bytes);
    dispatching = false;
    if (!cancelled.empty())
      for (const auto& node : std::exchange(cancelled, {})) take_out(node);
    return delivered;
  }

  void throw_failure() {
    if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
  }

  void append(std::string_view channel, std::span<const std::byte> bytes) {
    const HeaderInMemory header{static_cast<std::uint32_t>(channel.size()), static_cast<std::uint32_t>(bytes.size())};
    const std::size_t begin = waiting.size();
    waiting.resize(begin + sizeof header + channel.size() + bytes.size());
    std::byte* to = waiting.data() + begin;
    std::memcpy(to, &header, sizeof header);
    std::memcpy(to + sizeof header, channel.data(), channel.size());
    if (!bytes.empty()) std::memcpy(to + sizeof header + channel.size(), bytes.data(), bytes.size());
  }

  // How many of what is in hand a handler ran for. A failure leaves the rest for the next time.
  int handle_in_hand() {
    int heard = 0;
    std::span<const std::byte> rest = in_hand;
    while (!rest.empty() && !failure) {
      HeaderInMemory header;
      std::memcpy(&header, rest.data(), sizeof header);
      const auto channel = rest.subspan(sizeof header, header.channel_bytes);
      const auto bytes = rest.subspan(sizeof header + header.channel_bytes, header.data_bytes);
      rest = rest.subspan(sizeof header + channel.size() + bytes.size());
      heard += handle({reinterpret_cast<const char*>(channel.data()), channel.size()}, bytes);
    }
    unheard.assign(rest.begin(), rest.end());
    return heard;
  }

  // All that waits in memory, also what handlers publish meanwhile.
  int drain_memory() {
    int heard = 0;
    while (!unheard.empty() || !waiting.empty()) {
      std::vector<std::byte>& next = unheard.empty() ? waiting : unheard;
      in_hand.swap(next);
      next.clear();
      heard += handle_in_hand();
      throw_failure();
    }
    return heard;
  }

  // Opens the socket, and sends a word to itself as LCM does: false when nothing comes back.
  bool listen(const std::string& url) {
    if (receiver) return true;
    const MulticastUrl parts(url);
    try {
      receiver = std::make_unique<MulticastReceiver>(parts, hear);
    } catch (const std::system_error& error) {
      throw std::runtime_error(fmt::format("bus {}: cannot listen: {}", url, error.what()));
    }
    if (std::cmp_less(receiver->buffer_bytes(), parts.receive_buffer_bytes))
      spdlog::warn(
          "bus {}: its receive buffer has only {} bytes, so bursts may be lost; as root: sysctl -w "
          "net.core.rmem_max={}",
          url, receiver->buffer_bytes(), parts.receive_buffer_bytes);
    for (int attempt = 0; attempt < 100; ++attempt) {
      lcm_publish(lcm, self_test_channel.data(), "", 0);
      if (readable(std::chrono::milliseconds{100})) return true;
    }
    receiver.reset();
    return false;
  }

  bool readable(std::chrono::milliseconds wait) const {
    pollfd descriptor{receiver->descriptor(), POLLIN, 0};
    return poll(&descriptor, 1, static_cast<int>(std::clamp<long long>(wait.count(), 0, 1'000'000'000))) > 0;
  }
};

Bus::Bus(const std::string& url, const std::vector<std::string>& hear) : state_(std::make_unique<State>()), url_(url) {
  if (url.starts_with(memory_scheme)) {
    state_->in_memory = true;
  } else if (url.starts_with(multicast_scheme)) {
    if (!has_route(MulticastUrl(url).group)) throw_no_route(url);
  } else {
    throw std::runtime_error(fmt::format(
        "bus {}: must be memq:// or udpm://ADDRESS:PORT?ttl=0, for example udpm://239.255.76.67:7701?ttl=0", url));
  }
  for (const std::string& host : hear)
    if (in_addr address{}; inet_pton(AF_INET, host.c_str(), &address) == 1) state_->hear.push_back(address.s_addr);
  if (state_->in_memory) return;
  state_->lcm = lcm_create(url.c_str());
  if (!state_->lcm)
    throw std::runtime_error(fmt::format(
        "bus {}: LCM cannot open it; check address and port, for example udpm://239.255.76.67:7701?ttl=0", url));
}

Bus::~Bus() {
  assert(!state_->dispatching && "a handler may not destroy its own bus");
}

std::unique_ptr<Bus::Subscription> Bus::subscribe(const std::string& channel_pattern, Handler handler) {
  // A pattern is anchored as LCM means it: "a|b" needs the brackets.
  const std::string pattern = "(?:" + channel_pattern + ")";
  const std::shared_ptr<GRegex> regex(
      g_regex_new(("^" + pattern + "$").c_str(), GRegexCompileFlags{}, GRegexMatchFlags{}, nullptr),
      [](GRegex* r) { r ? g_regex_unref(r) : void(); });
  if (!regex) throw std::runtime_error(fmt::format("'{}' is not a channel pattern", channel_pattern));

  auto node = std::make_shared<State::Node>();
  node->bus = state_.get();
  node->handler = std::move(handler);
  node->pattern = regex;
  state_->routes.clear();
  if (!state_->in_memory && !state_->listen(url_)) throw_no_route(url_);
  state_->nodes.push_back(node);
  return std::make_unique<State::Handle>(std::move(node));
}

bool Bus::takes(const std::string& channel) {
  if (channel.empty() || channel.size() > LCM_MAX_CHANNEL_NAME_LENGTH || channel.find('\0') != std::string::npos) {
    counters_.add("refused.channel_name");
    return false;
  }
  return !state_->in_memory || !state_->route_of(channel)->empty();
}

void Bus::send(const std::string& channel, std::span<const std::byte> bytes) {
  State& state = *state_;
  if (state.in_memory) return state.append(channel, bytes);
  if (lcm_publish(state.lcm, channel.c_str(), bytes.data(), static_cast<unsigned>(bytes.size())) != 0)
    counters_.add("refused.send_failed");
}

int Bus::drain(std::chrono::milliseconds wait, int most) {
  State& state = *state_;
  if (state.in_memory) return state.drain_memory();
  int delivered = 0;
  if (!state.listen(url_)) throw_no_route(url_);
  const auto until = std::chrono::steady_clock::now() + wait;
  std::optional<MulticastReceiver::Message> message;
  // Not in the midst of what was fetched already: the descriptor does not tell of it.
  for (int taken = 0; taken < most || state.receiver->has_fetched();) {
    if (state.receiver->take(message)) {
      ++taken;
      if (message && message->channel != self_test_channel) delivered += state.handle(message->channel, message->bytes);
      state.throw_failure();
      continue;
    }
    if (delivered > 0 || wait.count() <= 0) break;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    if (left.count() <= 0 || !state.readable(left)) break;
  }
  return delivered;
}

int Bus::descriptor() const {
  assert(!state_->in_memory);
  if (!state_->listen(url_)) throw_no_route(url_);
  return state_->receiver->descriptor();
}

Counters Bus::counters() const {
  Counters all = counters_;
  if (state_->receiver) all.merge(state_->receiver->counters());
  return all;
}

}  // namespace arkmesh::hal
