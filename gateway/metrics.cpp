// Families in a fixed order; within one the order of the message.
#include "gateway/metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "hal/label.hpp"

namespace arkmesh::gateway {
namespace {

constexpr std::size_t longest_label = 200;
constexpr double us = 1e-6;

// Counters that tell what is now, not what has been in all.
bool is_level(std::string_view name) {
  constexpr std::array<std::string_view, 4> levels{"outbox.waiting.", "outbox.in_flight.", "outbox.queued.",
                                                   "certificate."};
  return std::ranges::any_of(levels, [&](std::string_view level) { return name.starts_with(level); });
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : hal::printable(text, longest_label)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

// All values of one name, with the two lines that go before them.
class Family {
 public:
  Family(std::string name, std::string_view kind, std::string_view help) : name_(std::move(name)) {
    head_ = fmt::format("# HELP {0} {1}\n# TYPE {0} {2}\n", name_, help, kind);
  }
  void add(const std::string& labels, double value) { values_ += fmt::format("{}{{{}}} {}\n", name_, labels, value); }
  // Nothing without values.
  std::string text() const { return values_.empty() ? values_ : head_ + values_; }

 private:
  std::string name_, head_, values_;
};

}  // namespace

std::string to_metrics(const peers_t& peers) {
  Family up("arkmesh_peer_up", "gauge", "1 while a session with the peer is open");
  Family trip("arkmesh_peer_round_trip_seconds", "gauge", "fastest recent round trip of a heartbeat");
  Family offset("arkmesh_peer_clock_offset_seconds", "gauge", "offset of the peer's wall clock from this one");
  Family doubt("arkmesh_peer_clock_uncertainty_seconds", "gauge", "largest error of the offset");
  Family age("arkmesh_channel_age_seconds", "gauge", "time since the newest message of a peer's channel");
  Family messages("arkmesh_channel_messages_total", "counter", "messages of a peer's channel");
  Family bytes("arkmesh_channel_bytes_total", "counter", "bytes of a peer's channel");
  Family levels("arkmesh_peer_level", "gauge", "current values, named as in the message `peers`");
  Family totals("arkmesh_peer_events_total", "counter", "totals, named as in the message `peers`");
  Family own("arkmesh_gateway_events_total", "counter", "totals of no single peer, named as in the message `peers`");
  const std::string lab = "lab=" + quoted(peers.lab);
  for (const peer_t& peer : peers.peers) {
    const std::string labels = lab + ",peer=" + quoted(peer.lab);
    up.add(labels, peer.up ? 1 : 0);
    if (peer.round_trip_us >= 0) {
      trip.add(labels, us * static_cast<double>(peer.round_trip_us));
      offset.add(labels, us * static_cast<double>(peer.clock_offset_us));
      doubt.add(labels, us * static_cast<double>(peer.clock_uncertainty_us));
    }
    for (const channel_age_t& channel : peer.channels) {
      const std::string with_channel = labels + ",channel=" + quoted(channel.channel);
      age.add(with_channel, us * static_cast<double>(channel.age_us));
      messages.add(with_channel, static_cast<double>(channel.messages));
      bytes.add(with_channel, static_cast<double>(channel.bytes));
    }
    for (const counter_t& counter : peer.counters)
      (is_level(counter.name) ? levels : totals)
          .add(labels + ",name=" + quoted(counter.name), static_cast<double>(counter.value));
  }
  for (const counter_t& counter : peers.counters)
    own.add(lab + ",name=" + quoted(counter.name), static_cast<double>(counter.value));
  std::string text;
  for (const Family* family : {&up, &trip, &offset, &doubt, &age, &messages, &bytes, &levels, &totals, &own})
    text += family->text();
  return text;
}

}  // namespace arkmesh::gateway
