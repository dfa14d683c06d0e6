// Notices that another lab, or another gateway of this lab, uses our LCM port and group, which would mix two labs
// without any error.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hal/arenas/neighbour_detector.hpp"
#include "hal/bus/bus.hpp"
#include "hal/counters.hpp"

namespace arkmesh::gateway {

class PortMonitor {
 public:
  // Listens to `status` and `peers` on the lab's bus. The bus outlives the watch.
  PortMonitor(hal::Bus& bus, std::string lab, std::uint64_t boot_id);

  // Asks gateways on this port to make themselves heard: they answer a foreign `peers` with theirs (see heard_other()).
  void ask();
  // One sentence about who was here before us: a lab, or a gateway with an older boot id. Empty while nobody was heard.
  const std::string& earlier() const { return earlier_; }
  // Another one was heard since the last call, earlier or later than us: make ourselves heard.
  bool heard_other();
  // How often somebody who does not belong here was heard.
  hal::Counters counters() const;

 private:
  void hear(const hal::Talker& other);
  void note_lab(std::string_view other, bool was_here_before);

  hal::Bus& bus_;
  std::string lab_;
  std::uint64_t boot_id_;
  std::string earlier_;
  bool heard_other_ = false;
  hal::Counters counters_;
  hal::NeighbourDetector detector_;
};

}  // namespace arkmesh::gateway
