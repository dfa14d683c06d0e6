#include "lab/operator/command_audit.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <map>

#include "arkmesh/operator_command_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/label.hpp"

namespace arkmesh::lab {
namespace {

constexpr int most_refused = 1000;

}  // namespace

std::string CommandAudit::word_of(int command) {
  static const std::map<int, std::string> words{{-1, ""},
                                                {fleet_command_t::run, "resume"},
                                                {fleet_command_t::pause, "pause"},
                                                {fleet_command_t::reset, "reset"},
                                                {operator_command_t::stop, "stop"},
                                                {operator_command_t::arm, "arm"},
                                                {operator_command_t::disarm, "disarm"}};
  const auto word = words.find(command);
  return word == words.end() ? fmt::format("{}", command) : word->second;
}

void CommandAudit::admitted(const std::string& peer, std::string_view command) {
  row(peer, command, "admitted");
  recorder_.flush();
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
