#include "hal/bus/loss.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "hal/counted.hpp"

namespace arkmesh::hal {

bool is_loss(std::string_view name) {
  static constexpr std::array<std::string_view, 13> words{"dropped",  "expired", "gap",     "ignored",  "late",
                                                          "lost",     "missing", "refused", "not_sent", "not_recorded",
                                                          "replaced", "skipped", "withheld"};
  while (!name.empty()) {
    const auto end = std::min(name.find('.'), name.size());
    if (std::ranges::find(words, name.substr(0, end)) != words.end()) return true;
    name.remove_prefix(std::min(end + 1, name.size()));
  }
  return false;
}

std::vector<std::string> loss_words(const Counters& counters, const std::string& prefix) {
  std::vector<std::string> out;
  const auto count = [&](const char* name) { return counters[prefix + name]; };
  const auto say_most = [&](std::uint64_t lost, std::uint64_t all, const char* what, const char* why) {
    const bool most = lost * 2 > all;
    if (most) out.push_back(fmt::format("{} of {} {}: {}", lost, all, what, why));
    return most;
  };
  const std::uint64_t sent = count("infrared.sent"), deaf = count("infrared.pairs.deaf");
  const bool refused =
      say_most(count("infrared.refused.crc"), sent, "infrared messages refused",
               "their checksum does not match their content; robots refuse them, ARGoS does not check");
  if (!say_most(count("infrared.refused.type"), sent, "infrared messages kept from programs",
                "types above 127 belong to robots' firmware; ARGoS passes them on") &&
      !refused && deaf > 0)
    out.push_back(fmt::format("{} of {} pairs in reach heard nothing of each other for a minute or longer: {}", deaf,
                              count("infrared.pairs.in_reach"),
                              count("infrared.lost.crowded") > 0
                                  ? "by ARGoS's rules a robot hears four messages per tick, those of the first robots"
                                  : "usually two senders that do not hear each other collide, or the overhead "
                                    "controller sends all the time"));
  const std::uint64_t bad = count("overhead.refused.crc") + count("overhead.distorted");
  say_most(bad, bad + count("overhead.heard"), "overhead messages refused",
           "copies are distorted or their checksum is wrong; packets that follow each other within 50 ms distort them");
  const std::uint64_t offered = counters["to_robots.offered"], replaced = counters["to_robots.replaced"];
  say_most(counters["to_robots.refused"], offered, "words to robots refused",
           "ids, kinds, values or types that do not fit the message layout; to_robots.refused counts them by reason");
  if (replaced * 4 > offered)
    out.push_back(
        fmt::format("{} of {} words to robots replaced by newer ones before they were sent: they need {:.0f} % of the "
                    "overhead controller's airtime; send less, or less often",
                    replaced, offered, 100.0 * static_cast<double>(offered) / static_cast<double>(offered - replaced)));
  return out;
}

std::string tracking_words(const Counters& counters, const std::string& prefix) {
  const auto root_mean = [&](const std::string& what, const char* sum, double unit) {
    return std::sqrt(static_cast<double>(counters[prefix + what + sum]) * unit /
                     static_cast<double>(counters[prefix + what]));
  };
  if (counters[prefix + "track.places"] == 0) return {};
  std::string words =
      fmt::format("tracked robots were seen {:.2f} mm from their predicted places, {:.2f} times the stated deviation",
                  root_mean("track.places", ".off_um2", 1e-6), root_mean("track.places", ".misfit", 0.01));
  if (counters[prefix + "track.headings"] > 0)
    words += fmt::format("; their LEDs {:.1f} degrees, {:.2f} times",
                         root_mean("track.headings", ".off_mrad2", 1e-6) * 180 / std::numbers::pi,
                         root_mean("track.headings", ".misfit", 0.01));
  return words +
         fmt::format("; {} had been mistaken for another", counted(counters[prefix + "track.renamed"], "robot"));
}

}  // namespace arkmesh::hal
