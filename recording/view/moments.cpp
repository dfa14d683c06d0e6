#include "recording/view/moments.hpp"

#include <algorithm>

#include "hal/layout/types.hpp"

namespace arkmesh::recording {
namespace {

std::vector<std::size_t> channels_of(const Log& log, const std::vector<std::string>& names) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < log.channels().size(); ++i)
    if (names.empty() || std::ranges::find(names, log.channels()[i]) != names.end()) out.push_back(i);
  return out;
}

// Whether several messages make one frame.
bool has_parts(const Log& log, std::size_t channel) {
  const hal::layout::Type* const type = hal::layout::types().of_channel(log.channels()[channel]);
  return type &&
         std::ranges::any_of(type->fields, [](const hal::layout::Field& field) { return field.name == "parts"; });
}

// The newest message and, of a frame in parts, those of the same time before it: [first, last] of the channel's own
// list.
bool give_newest(const Log& log, std::size_t channel, std::uint32_t newest, const Give& give) {
  const auto all = log.of_channel(channel);
  const auto last = std::ranges::lower_bound(all, newest);
  auto first = last;
  if (has_parts(log, channel))
    while (first != all.begin() && log.entries()[*(first - 1)].t_us == log.entries()[newest].t_us) --first;
  for (auto at = first; at <= last; ++at) {
    const Log::Entry& entry = log.entries()[*at];
    const auto message = log.read(entry);
    if (!message.empty() && !give(entry.t_us, log.channels()[channel], message)) return false;
  }
  return true;
}

}  // namespace

bool give_moment(const Log& log, std::int64_t t_us, const std::vector<std::string>& channels, const Give& give) {
  for (const std::size_t channel : channels_of(log, channels))
    if (const auto newest = log.newest(channel, t_us); newest && !give_newest(log, channel, *newest, give))
      return false;
  return true;
}

bool give_row(const Log& log, const Row& row, const std::vector<std::string>& channels, const Give& give) {
  const auto all = channels_of(log, channels);
  std::vector<std::optional<std::uint32_t>> given;
  for (const std::size_t channel : all) given.push_back(log.newest(channel, row.from_us - row.step_us));
  for (std::int64_t k = 0; k < row.count; ++k) {
    const std::int64_t t_us = row.from_us + k * row.step_us;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto newest = log.newest(all[i], t_us);
      if (!newest || newest == given[i]) continue;
      given[i] = newest;
      if (!give_newest(log, all[i], *newest, give)) return false;
    }
    if (t_us > log.length_us()) break;
  }
  return true;
}

}  // namespace arkmesh::recording
