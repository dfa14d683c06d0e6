#include "gateway/port_monitor.hpp"

#include <fmt/format.h>

#include <utility>

#include "arkmesh/peers_t.hpp"
#include "hal/arenas/messages.hpp"

namespace arkmesh::gateway {

PortMonitor::PortMonitor(hal::Bus& bus, std::string lab, std::uint64_t boot_id)
    : bus_(bus),
      lab_(std::move(lab)),
      boot_id_(boot_id),
      detector_(bus, [this](const hal::Talker& other) { hear(other); }) {}

void PortMonitor::ask() {
  peers_t message;
  message.lab = lab_;
  message.boot_id = static_cast<std::int64_t>(boot_id_);
  message.n_peers = message.n_counters = 0;
  bus_.publish(hal::channel::peers, message);
}

bool PortMonitor::heard_other() {
  return std::exchange(heard_other_, false);
}

void PortMonitor::hear(const hal::Talker& other) {
  if (!other.is_gateway) {
    if (other.lab != lab_) note_lab(other.lab, true);
    return;
  }
  if (other.lab == lab_ && other.number == boot_id_) return;
  heard_other_ = true;
  const bool was_here_before = other.number < boot_id_;
  if (other.lab != lab_) return note_lab(other.lab, was_here_before);
  counters_.add("bus.second_gateway");
  if (was_here_before)
    earlier_ = fmt::format("bus {}: another gateway of lab {} runs already; stop it first", bus_.url(), lab_);
}

hal::Counters PortMonitor::counters() const {
  hal::Counters all = counters_;
  all.merge(detector_.counters());
  return all;
}

void PortMonitor::note_lab(std::string_view other, bool was_here_before) {
  counters_.add(fmt::format("bus.other_lab.{}", other));
  if (was_here_before)
    earlier_ = fmt::format("bus {}: lab {} uses this LCM port as well; give each lab its own port in bus.url",
                           bus_.url(), other);
}

}  // namespace arkmesh::gateway
