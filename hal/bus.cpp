// Owns an LCM handle. Keeps C++ out of LCM's C frames: exceptions of handlers are kept and thrown again by drain(), and
// a subscription that dies inside a handler is taken out of LCM only after LCM has finished with that message.
#include "hal/bus.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <glib.h>
#include <lcm/lcm.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <exception>
#include <stdexcept>
#include <utility>

namespace arkmesh::hal {

namespace {

constexpr std::string_view memory_scheme = "memq://", multicast_scheme = "udpm://";

// Whether this machine can send to the multicast group of `url`. True for what is no address: LCM judges that.
bool has_route(std::string_view url) {
  std::string group(url.substr(multicast_scheme.size()));
  group.resize(std::min(group.find_first_of(":?"), group.size()));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7667);
  if (inet_pton(AF_INET, group.empty() ? "239.255.76.67" : group.c_str(), &address.sin_addr) != 1) return true;
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return true;
  const bool reached = connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  const bool route = reached || (errno != ENETUNREACH && errno != EHOSTUNREACH && errno != ENETDOWN);
  close(probe);
  return route;
}

[[noreturn]] void throw_no_route(const std::string& url) {
  throw std::runtime_error(fmt::format(
      "bus {}: this machine has no multicast route; make one with: ip link set lo up; ip route add 224.0.0.0/4 dev lo",
      url));
}

}  // namespace

struct Bus::State {
  // One subscription, as LCM calls it back. Lives until LCM has let go of it.
  struct Node {
    State* bus = nullptr;  // null when the bus is gone
    lcm_subscription_t* subscription = nullptr;
    bool cancelled = false;
    Handler handler;
  };

  class Handle final : public Subscription {
   public:
    explicit Handle(std::shared_ptr<Node> node) : node_(std::move(node)) {}
    ~Handle() override {
      if (node_->bus) node_->bus->cancel(node_);
    }

   private:
    std::shared_ptr<Node> node_;  // shared with the bus: either may die first
  };

  lcm_t* lcm = nullptr;
  bool in_memory = false;
  int waiting = 0;  // memq only: published and not yet handled
  bool dispatching = false;
  bool delivered = false;  // a handler ran for the message in hand
  std::exception_ptr failure;
  std::vector<std::shared_ptr<Node>> nodes;
  std::vector<std::shared_ptr<Node>> cancelled;  // to be taken out of LCM after the message in hand

  static void on_message(const lcm_recv_buf_t* buffer, const char* channel, void* user) {
    Node& node = *static_cast<Node*>(user);
    if (node.cancelled) return;
    State& bus = *node.bus;
    bus.delivered = true;
    try {
      node.handler(channel, {static_cast<const std::byte*>(buffer->data), buffer->data_size});
    } catch (...) {
      if (!bus.failure) bus.failure = std::current_exception();
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
    lcm_unsubscribe(lcm, node->subscription);
    node->bus = nullptr;
    std::erase(nodes, node);
  }

  // Handles one message that is known to wait. True when a handler of ours ran.
  bool handle_one() {
    assert(!dispatching && "a handler may not drain its own bus");
    dispatching = true;
    delivered = false;
    lcm_handle(lcm);
    dispatching = false;
    if (!cancelled.empty())
      for (const auto& node : std::exchange(cancelled, {})) take_out(node);
    if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
    return delivered;
  }

  bool readable(std::chrono::milliseconds wait) const {
    pollfd descriptor{lcm_get_fileno(lcm), POLLIN, 0};
    return poll(&descriptor, 1, static_cast<int>(std::clamp<long long>(wait.count(), 0, 1'000'000'000))) > 0;
  }
};

Bus::Bus(const std::string& url) : state_(std::make_unique<State>()), url_(url) {
  std::string full_url = url;
  if (url.starts_with(memory_scheme)) {
    state_->in_memory = true;
  } else if (url.starts_with(multicast_scheme)) {
    if (!has_route(url)) throw_no_route(url);
    if (url.find("recv_buf_size=") == std::string::npos)
      full_url += (url.find('?') == std::string::npos ? "?" : "&") + std::string("recv_buf_size=4194304");
  } else {
    throw std::runtime_error(fmt::format(
        "bus {}: must be memq:// or udpm://ADDRESS:PORT?ttl=0, for example udpm://239.255.76.67:7701?ttl=0", url));
  }
  state_->lcm = lcm_create(full_url.c_str());
  if (!state_->lcm)
    throw std::runtime_error(fmt::format(
        "bus {}: LCM cannot open it; check address and port, for example udpm://239.255.76.67:7701?ttl=0", url));
  // LCM drops memq messages that nobody subscribed to. With this one, every message published is a message to handle,
  // so that drain() needs no system call to learn whether one waits.
  if (state_->in_memory)
    lcm_subscribe(
        state_->lcm, ".*", [](const lcm_recv_buf_t*, const char*, void*) {}, nullptr);
}

Bus::~Bus() {
  assert(!state_->dispatching && "a handler may not destroy its own bus");
  for (const auto& node : state_->nodes) node->bus = nullptr;
  lcm_destroy(state_->lcm);
}

std::unique_ptr<Bus::Subscription> Bus::subscribe(const std::string& channel_pattern, Handler handler) {
  // LCM anchors a pattern only at its outer ends: "a|b" needs the brackets. What it makes of a bad one is a leak.
  const std::string pattern = "(?:" + channel_pattern + ")";
  GRegex* regex = g_regex_new(pattern.c_str(), GRegexCompileFlags{}, GRegexMatchFlags{}, nullptr);
  if (!regex) throw std::runtime_error(fmt::format("'{}' is no channel pattern", channel_pattern));
  g_regex_unref(regex);

  auto node = std::make_shared<State::Node>();
  node->bus = state_.get();
  node->handler = std::move(handler);
  node->subscription = lcm_subscribe(state_->lcm, pattern.c_str(), &State::on_message, node.get());
  if (!node->subscription) throw_no_route(url_);               // LCM's self-test did not hear itself
  lcm_subscription_set_queue_capacity(node->subscription, 0);  // 0: no limit
  state_->nodes.push_back(node);
  return std::make_unique<State::Handle>(std::move(node));
}

void Bus::publish(const std::string& channel, std::span<const std::byte> bytes) {
  if (channel.empty() || channel.size() > LCM_MAX_CHANNEL_NAME_LENGTH || channel.find('\0') != std::string::npos) {
    counters_.add("refused.channel_name");
    return;
  }
  if (lcm_publish(state_->lcm, channel.c_str(), bytes.data(), static_cast<unsigned>(bytes.size())) != 0)
    counters_.add("refused.send_failed");
  else if (state_->in_memory)
    ++state_->waiting;
}

int Bus::drain(std::chrono::milliseconds wait, int most) {
  int delivered = 0;
  if (state_->in_memory) {
    if (state_->waiting == 0 && wait.count() > 0) state_->readable(wait);
    while (state_->waiting > 0) {
      --state_->waiting;
      delivered += state_->handle_one();
    }
    return delivered;
  }
  for (int taken = 0; taken < most && state_->readable(taken == 0 ? wait : std::chrono::milliseconds{0}); ++taken)
    delivered += state_->handle_one();
  return delivered;
}

int Bus::descriptor() const {
  return lcm_get_fileno(state_->lcm);
}

}  // namespace arkmesh::hal
