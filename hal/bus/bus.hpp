// A lab's message bus: a thin owner of an LCM handle. The LCM URL picks the transport ("memq://" in one process,
// "udpm://239.255.76.67:7701?ttl=0" between the processes of a lab). Adds raw handlers that die with their handle,
// queue sizes that do not lose messages, counters, and on a network a receiver that hears only who may speak. Not
// thread-safe.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"
#include "hal/layout/message.hpp"

namespace arkmesh::hal {

class Bus {
 public:
  using Handler = std::function<void(std::string_view channel, std::span<const std::byte> bytes)>;

  // While it lives the handler may be called; when it dies the handler cannot be called any more.
  class Subscription {
   public:
    virtual ~Subscription() = default;
  };

  // `hear`: hosts that a network bus hears beside this machine, by IPv4 address.
  // Throws std::runtime_error with one sentence (no multicast route: names the command that makes one).
  explicit Bus(const std::string& url, const std::vector<std::string>& hear = {});
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  // `channel_pattern` is an LCM regular expression, anchored at both ends ("[^/]+/world", ".*"). The first one opens
  // the receiving socket of a network bus, which throws std::runtime_error when the bus does not hear itself.
  [[nodiscard]] std::unique_ptr<Subscription> subscribe(const std::string& channel_pattern, Handler handler);

  // In memory only those who have subscribed before get it.
  void publish(const std::string& channel, std::span<const std::byte> bytes) {
    if (takes(channel)) send(channel, bytes);
  }

  template <class Message>
  requires requires(const Message& message) { message.getEncodedSize(); }
  void publish(const std::string& channel, const Message& message) {
    if (!takes(channel)) return;
    scratch_.resize(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(scratch_.data(), 0, static_cast<int>(scratch_.size()));
    send(channel, scratch_);
  }

  // Delivers everything that has arrived; on a network waits up to `wait` for the first message when there is none.
  // Returns how many were delivered. A handler may publish and subscribe; what it publishes on memq is delivered too.
  // A network bus stops after about `most` packets, so that a flood cannot keep it from returning; descriptor() stays
  // readable. After a handler's exception the next drain() goes on, whatever descriptor() says.
  int drain(std::chrono::milliseconds wait = std::chrono::milliseconds{0}, int most = 10'000);

  // Of a network bus: readable when a message waits; for joining another event loop. Throws as subscribe() does.
  int descriptor() const;
  const std::string& url() const { return url_; }
  // What was refused or lost, up to now.
  Counters counters() const;

 private:
  // False where nobody can hear it, so that it need not be made, or the name is refused.
  bool takes(const std::string& channel);
  void send(const std::string& channel, std::span<const std::byte> bytes);
  struct State;
  std::unique_ptr<State> state_;
  std::string url_;
  std::vector<std::byte> scratch_;
  Counters counters_;
};

// Texts in our messages are names, reasons and settings; none takes more bytes, its final NUL included.
inline constexpr std::size_t max_text = 4096;

// Decodes a message that may come from anywhere: LCM's generated decoders trust counts, so all of it is checked before.
// Empty when the bytes are exactly one message of today's layout, else the reason in one word (as layout::check, or
// "undecodable"). Never throws.
template <class Message>
std::string_view read_message(std::span<const std::byte> bytes, Message& message) {
  if (const std::string_view why = layout::check(layout::type_for<Message>(), bytes, max_text); !why.empty())
    return why;
  try {
    const auto size = static_cast<int>(bytes.size());
    return message.decode(bytes.data(), 0, size) == size ? "" : "undecodable";
  } catch (const std::exception&) {
    return "undecodable";
  }
}

// The same for those who do not ask for the reason.
template <class Message>
bool decode(std::span<const std::byte> bytes, Message& message) {
  return read_message(bytes, message).empty();
}

}  // namespace arkmesh::hal
