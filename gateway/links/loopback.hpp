// Links between gateways of one process, in memory, with delay, loss and outage on demand. Time is counted in steps,
// never in wall time, so that whole labs can be tested reproducibly.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "gateway/link.hpp"

namespace arkmesh::gateway {

struct LoopbackImpairment {
  std::uint32_t delay_steps = 0;   // a message is delivered this many steps after it was offered
  std::uint32_t jitter_steps = 0;  // plus 0..jitter steps, drawn per message; order is kept
  double loss = 0;    // 0..1, drawn per message: it is dropped and counted (a real TCP link loses only by outage)
  double repeat = 0;  // 0..1, drawn per message: it is delivered twice
};

// Joins the loopback links of one process. Outlives its links.
class LoopbackNetwork {
 public:
  explicit LoopbackNetwork(std::uint64_t seed);
  ~LoopbackNetwork();
  // The end of the link between `lab` and `peer` that lab's gateway holds. The link is up while both ends live, were
  // started and set_up did not take it down; an end may be made anew after the old one died (a gateway that was started
  // again).
  std::unique_ptr<Link> end(const std::string& lab, const std::string& peer);
  // Both directions.
  void impair(const std::string& a, const std::string& b, LoopbackImpairment impairment);
  // Takes the link down or up; what was under way is lost and counted.
  void set_up(const std::string& a, const std::string& b, bool up);
  // One step of time: delivers what is due. Returns how many messages were delivered.
  int step();
  // Something is under way.
  bool busy() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace arkmesh::gateway
