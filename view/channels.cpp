#include "view/channels.hpp"

#include <algorithm>
#include <memory>
#include <utility>

namespace arkmesh::view {

void Channels::note(Kind kind, int lab, std::int64_t t_us, std::string_view name, std::span<const std::byte> data,
                    Part part) {
  if (lab < 0 || lab > 255) return counters_.add("view.skipped.no_such_lab");
  if (static_cast<std::size_t>(lab) >= labs_.size()) labs_.resize(static_cast<std::size_t>(lab) + 1);
  auto& channels = labs_[static_cast<std::size_t>(lab)];
  auto found = channels.find(name);
  if (found == channels.end()) {
    if (slots_ >= max_channels) return counters_.add("view.skipped.too_many_channels");
    found = channels.emplace(std::string(name), Channel{.kind = kind, .slot = slots_++}).first;
  }
  Channel& channel = found->second;
  const std::size_t makes_way = part.parts == 1 ? channel.newest.data.size() : 0;
  if (bytes_ - makes_way + data.size() > max_bytes) return counters_.add("view.skipped.too_many_bytes");
  ++channel.messages;
  channel.bytes += data.size();
  newest_us_ = std::max(newest_us_, t_us);
  if (!build(channel, data, part)) return;
  std::swap(channel.newest, channel.building);
  bytes_ -= channel.building.data.size();
  channel.building.data.clear();
  channel.building.ends.clear();
  channel.t_us = t_us;
  channel.fresh = true;
  channel.parcel = {};
}

bool Channels::build(Channel& channel, std::span<const std::byte> data, Part part) {
  Messages& building = channel.building;
  if (part.frame != channel.frame || part.part == 0) {
    if (!building.ends.empty()) leave_out(channel);
    channel.frame = part.frame;
    channel.lacks_part = false;
  }
  if (channel.lacks_part) return false;
  if (std::cmp_not_equal(part.part, building.ends.size())) {
    leave_out(channel);
    return false;
  }
  building.data.insert(building.data.end(), data.begin(), data.end());
  building.ends.push_back(building.data.size());
  bytes_ += data.size();
  return std::cmp_equal(building.ends.size(), part.parts);
}

void Channels::leave_out(Channel& channel) {
  counters_.add("view.skipped.part_missing");
  channel.lacks_part = true;
  bytes_ -= channel.building.data.size();
  channel.building.data.clear();
  channel.building.ends.clear();
}

const Parcel& Channels::parcel_of(int lab, const std::string& name, Channel& channel) const {
  if (channel.parcel.bytes || channel.newest.ends.empty()) return channel.parcel;
  std::vector<std::string> frames;
  for (std::size_t from = 0; const std::size_t end : channel.newest.ends) {
    const auto message = std::span(channel.newest.data).subspan(from, end - from);
    frames.push_back(frame(channel.kind, lab, 0, channel.t_us, name, message));
    from = end;
  }
  channel.parcel.bytes =
      std::make_shared<const std::string>(frames.size() == 1 ? std::move(frames.front()) : bundle(frames));
  return channel.parcel;
}

std::vector<Channels::Sample> Channels::take_fresh() {
  std::vector<Sample> out;
  for (std::size_t lab = 0; lab < labs_.size(); ++lab)
    for (auto& [name, channel] : labs_[lab])
      if (std::exchange(channel.fresh, false))
        out.push_back({channel.slot, parcel_of(static_cast<int>(lab), name, channel)});
  return out;
}

std::vector<Channels::Sample> Channels::all() {
  std::vector<Sample> out;
  for (std::size_t lab = 0; lab < labs_.size(); ++lab)
    for (auto& [name, channel] : labs_[lab])
      if (!channel.newest.ends.empty()) out.push_back({channel.slot, parcel_of(static_cast<int>(lab), name, channel)});
  return out;
}

nlohmann::json Channels::rates(double seconds) {
  nlohmann::json labs = nlohmann::json::array();
  for (auto& channels : labs_) {
    nlohmann::json rows = nlohmann::json::object();
    for (auto& [name, channel] : channels) {
      const auto per_s = [&](std::uint64_t now, std::uint64_t& before) {
        return static_cast<double>(now - std::exchange(before, now)) / seconds;
      };
      rows[name] = {{"per_s", per_s(channel.messages, channel.messages_before)},
                    {"bytes_per_s", per_s(channel.bytes, channel.bytes_before)},
                    {"count", channel.messages}};
    }
    labs.push_back({{"channels", std::move(rows)}});
  }
  return labs;
}

void Channels::start_rates() {
  for (auto& channels : labs_)
    for (auto& [name, channel] : channels) {
      channel.messages_before = channel.messages;
      channel.bytes_before = channel.bytes;
    }
}

}  // namespace arkmesh::view
