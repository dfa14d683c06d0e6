// Exports channels of a lab's bus to its peers, by rules, and republishes theirs under their lab's name. Looks at
// channel names only; never decodes a payload. Exports no name with '/', so echoes cannot form.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "arkmesh/peers_t.hpp"
#include "gateway/channel_rules.hpp"
#include "gateway/link.hpp"
#include "hal/bus/bus.hpp"
#include "hal/counters.hpp"

namespace arkmesh::gateway {

class Gateway {
 public:
  // The bus outlives the gateway. `boot_id` is new at each start (0 is not allowed). What is exported from now on waits
  // in the links until start(). Only what `rules` let pass crosses, whatever a peer sends.
  Gateway(hal::Bus& bus, std::string lab, std::uint64_t boot_id, ChannelRules rules,
          std::vector<std::unique_ptr<Link>> links);
  ~Gateway();
  // Starts the links, once.
  void start();
  // Other rules from now on. What waits for peers and does not pass any more is dropped.
  void set_rules(ChannelRules rules);
  // Publishes `peers` (arkmesh.peers_t): ages are computed against `now`, any monotonic time that the caller keeps to
  // (wall time in a gateway process, step time inside `arkmesh run`). Call it once a second; changes of a link are
  // published at the next call of tick() as well. Returns whether it published. `more`: counters of the process around
  // the gateway, published with the gateway's own.
  bool tick(std::chrono::microseconds now, const hal::Counters& more = {});
  // That message.
  peers_t describe(std::chrono::microseconds now, const hal::Counters& more = {}) const;
  // The next tick() publishes, whatever the time.
  void announce();
  // Links in the order given.
  const std::vector<std::unique_ptr<Link>>& links() const;
  const hal::Counters& counters() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arkmesh::gateway
