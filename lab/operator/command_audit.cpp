#include "lab/operator/command_audit.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "arkmesh/operator_command_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/label.hpp"

namespace arkmesh::lab {
namespace {

constexpr int most_refused = 1000;

std::string word_of(int command) {
  switch (command) {
    case -1:
      return "";
    case fleet_command_t::run:
      return "resume";
    case fleet_command_t::pause:
      return "pause";
    case fleet_command_t::reset:
      return "reset";
    case operator_command_t::stop:
      return "stop";
    case operator_command_t::arm:
      return "arm";
    case operator_command_t::disarm:
      return "disarm";
    default:
      return fmt::format("{}", command);
  }
}

}  // namespace

void CommandAudit::admitted(const std::string& peer, int command) {
  row(peer, word_of(command), "admitted");
  recorder_.flush();
}

void CommandAudit::refused(const std::string& peer, int command, std::string_view why) {
  refused(peer, word_of(command), why);
}

void CommandAudit::refused(const std::string& peer, std::string_view command, std::string_view why) {
  if (refused_ > most_refused) return;
  if (++refused_ <= most_refused) return row(peer, command, why);
  row("", "", "further refusals are only counted");
}

// A peer's name may be anybody's text.
void CommandAudit::row(std::string_view peer, std::string_view command, std::string_view outcome) {
  std::string who = hal::printable(peer, hal::max_lab_name);
  std::replace_if(
      who.begin(), who.end(), [](char c) { return c == ',' || c == '"'; }, '?');
  recorder_.row("audit", "utc,lab_time_s,lab,command,outcome",
                fmt::format("{:%Y-%m-%dT%H:%M:%SZ},{:.3f},{},{},{}", fmt::gmtime(std::time(nullptr)),
                            static_cast<double>(clock_.now().count()) * 1e-6, who, command, outcome));
}

}  // namespace arkmesh::lab
