// Whether a link's books balance.
#pragma once

#include <doctest/doctest.h>

#include <string>
#include <string_view>

#include "gateway/link.hpp"

namespace arkmesh::tests {

// Of each channel what was accepted is acknowledged, in flight, queued, replaced, dropped or refused, exactly.
inline void check_accounts(const gateway::LinkStats& stats) {
  constexpr std::string_view accepted = "outbox.accepted.";
  for (const auto& [name, n] : stats.counters.all()) {
    if (!name.starts_with(accepted)) continue;
    const std::string channel = name.substr(accepted.size());
    CAPTURE(channel);
    std::uint64_t found = 0;
    for (const char* what : {"acknowledged", "in_flight", "queued", "replaced", "dropped.full", "dropped.session_lost",
                             "dropped.rate_limited", "dropped.over_budget", "dropped.denied", "refused.too_big"})
      found += stats.counters["outbox." + std::string(what) + "." + channel];
    CHECK(found == n);
  }
}

}  // namespace arkmesh::tests
