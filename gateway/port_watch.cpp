// Reads no more of these messages than who sent them; a foreign message may be of another version.
#include "gateway/port_watch.hpp"

#include <fmt/format.h>

#include <utility>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "hal/messages.hpp"
#include "hal/sender.hpp"

namespace arkmesh::gateway {

PortWatch::PortWatch(hal::Bus& bus, std::string lab, std::uint64_t boot_id)
    : bus_(bus), lab_(std::move(lab)), boot_id_(boot_id) {
  subscriptions_.push_back(
      bus.subscribe(hal::channel::status, [this](std::string_view, auto bytes) { hear_status(bytes); }));
  subscriptions_.push_back(
      bus.subscribe(hal::channel::peers, [this](std::string_view, auto bytes) { hear_peers(bytes); }));
}

void PortWatch::ask() {
  peers_t message;
  message.lab = lab_;
  message.boot_id = static_cast<std::int64_t>(boot_id_);
  message.n_peers = message.n_counters = 0;
  bus_.publish(hal::channel::peers, message);
}

bool PortWatch::heard_other() {
  return std::exchange(heard_other_, false);
}

void PortWatch::hear_status(std::span<const std::byte> bytes) {
  const auto sender = hal::read_sender(bytes, lab_status_t::getHash());
  if (!sender) return counters_.add("bus.ignored.status");
  if (sender->lab != lab_) note_lab(sender->lab, true);
}

void PortWatch::hear_peers(std::span<const std::byte> bytes) {
  const auto sender = hal::read_sender(bytes, peers_t::getHash());
  if (!sender) return counters_.add("bus.ignored.peers");
  if (sender->lab == lab_ && sender->number == boot_id_) return;
  heard_other_ = true;
  const bool was_here_before = sender->number < boot_id_;
  if (sender->lab != lab_) return note_lab(sender->lab, was_here_before);
  counters_.add("bus.second_gateway");
  if (was_here_before)
    earlier_ = fmt::format("bus {}: another gateway of lab {} runs already; stop it first", bus_.url(), lab_);
}

void PortWatch::note_lab(std::string_view other, bool was_here_before) {
  counters_.add(fmt::format("bus.other_lab.{}", other));
  if (was_here_before)
    earlier_ = fmt::format("bus {}: lab {} uses this LCM port, too; give each lab a port of its own in bus.url",
                           bus_.url(), other);
}

}  // namespace arkmesh::gateway
