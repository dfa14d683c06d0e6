#include "sim_ode/infrared_exchange.hpp"

namespace arkmesh::sim_ode {

void exchange_infrared(std::int64_t number, const ContactWorld& world, RobotHost& host, InfraredMedium& medium,
                       std::vector<Reception>& heard) {
  medium.begin_tick(number, world, host.offers());
  while (const std::optional<Outcome> outcome = medium.next()) {
    if (const int soon = medium.soon(); soon >= 0) host.fetch_memory(soon);
    const Reply reply = host.send_turn(*outcome);
    if (!reply.message) continue;
    if (outcome->free)
      medium.send(*reply.message);
    else
      medium.back_off(reply.back_off_us);
  }
  medium.end_tick(heard);
}

}  // namespace arkmesh::sim_ode
