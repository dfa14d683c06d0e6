#include "hal/bus/bus_config.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include "hal/bus/multicast_url.hpp"

namespace arkmesh::hal {

constexpr std::size_t max_heard_hosts = 250;  // the filter of the receiving socket asks for each in turn

void BusConfig::check(const Section& bus) const {
  if (!url.starts_with(multicast_scheme))
    bus.refuse("url", "must be udpm://ADDRESS:PORT?ttl=0, for example udpm://239.255.76.67:7701?ttl=0");
  for (const std::string& host : hear)
    if (in_addr address{}; inet_pton(AF_INET, host.c_str(), &address) != 1)
      bus.refuse("hear", fmt::format("'{}' is not an IPv4 address, for example 10.0.0.5", host));
  if (hear.size() > max_heard_hosts)
    bus.refuse("hear", fmt::format("names {} hosts; at most {} are possible", hear.size(), max_heard_hosts));
  if (!hear.empty() && !(url.starts_with(multicast_scheme) && MulticastUrl(url).ttl > 0))
    bus.refuse("hear",
               "names hosts, but the bus is confined to this machine; write ttl=1 in bus.url, here and on those hosts");
}

}  // namespace arkmesh::hal
