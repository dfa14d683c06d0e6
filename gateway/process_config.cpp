#include "gateway/process_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "hal/messages.hpp"

namespace arkmesh::gateway {

ProcessConfig read_process_config(const hal::Config& config) {
  const hal::Section root = config.root();
  ProcessConfig out;
  out.lab = root.section("lab").required_text("name");
  if (!hal::is_lab_name(out.lab))
    root.section("lab").refuse("name", fmt::format("must have 1 to {} of a-z, 0-9, '_' and '-'", hal::max_lab_name));
  const std::vector<std::string> labs = root.section("shared").texts("labs", {out.lab});
  if (std::ranges::find(labs, out.lab) == labs.end())
    root.section("shared").refuse("labs",
                                  fmt::format("does not name this lab, '{}'; add it or correct lab.name", out.lab));
  out.bus_url = root.section("bus").text("url", "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304");
  if (!out.bus_url.starts_with("udpm://"))
    root.section("bus").refuse("url", "must be udpm://ADDRESS:PORT?ttl=0, for example udpm://239.255.76.67:7701?ttl=0");
  out.gateway = read_gateway_config(root.section("gateway"), out.lab, labs);
  config.refuse_unknown("gateway");
  for (const std::string& lab : labs)
    if (lab != out.lab && std::ranges::find(out.gateway.peers, lab, &PeerConfig::lab) == out.gateway.peers.end())
      root.section("gateway").refuse("peers",
                                     fmt::format("has no entry for lab {}, which shared.labs names; add one", lab));
  return out;
}

}  // namespace arkmesh::gateway
