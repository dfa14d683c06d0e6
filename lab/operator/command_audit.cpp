#include "lab/operator/command_audit.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "hal/arenas/messages.hpp"
#include "hal/label.hpp"

namespace arkmesh::lab {
namespace {

constexpr int most_refused = 1000;

}  // namespace

// A peer's name may be anybody's text.
void CommandAudit::note(std::string_view peer, std::string_view command, std::string_view outcome) {
  if (outcome != admitted) {
    if (refused_ > most_refused) return;
    if (++refused_ > most_refused) peer = command = "", outcome = "further refusals are only counted";
  }
  std::string who = hal::printable(peer, hal::max_lab_name);
  std::replace_if(
      who.begin(), who.end(), [](char c) { return c == ',' || c == '"'; }, '?');
  recorder_.row("audit", "utc,lab_time_s,lab,command,outcome",
                fmt::format("{:%Y-%m-%dT%H:%M:%SZ},{:.3f},{},{},{}", fmt::gmtime(std::time(nullptr)),
                            static_cast<double>(clock_.now().count()) * 1e-6, who, command, outcome));
  if (outcome == admitted) recorder_.flush();
}

}  // namespace arkmesh::lab
