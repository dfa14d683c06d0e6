// Layout: magic, version, lab | version of arkmesh, experiment, boot id, largest message, channels with fingerprints.
// Names are one length byte and the text.
#include "gateway/frame/hello.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/world_t.hpp"
#include "gateway/frame/byte_fields.hpp"
#include "gateway/frame/channel_name.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/label.hpp"

namespace arkmesh::gateway {

namespace {

constexpr std::string_view magic = "ARKMESH\n";

void put_channels(std::vector<std::byte>& out, const std::vector<ExportedChannel>& channels) {
  put(out, static_cast<std::uint16_t>(channels.size()));
  for (const ExportedChannel& channel : channels) {
    put_name(out, channel.name);
    put(out, channel.type);
  }
}

std::optional<std::vector<ExportedChannel>> take_channels(FieldReader& in) {
  std::vector<ExportedChannel> all;
  const std::size_t channels = in.take<std::uint16_t>();
  if (channels > max_hello_channels) return {};
  for (std::size_t i = 0; i < channels && in.good(); ++i) {
    ExportedChannel channel;
    channel.name = in.take_name();
    channel.type = in.take<std::uint64_t>();
    if (!is_exported_name(channel.name)) return {};
    if (std::ranges::find(all, channel.name, &ExportedChannel::name) != all.end()) return {};
    all.push_back(std::move(channel));
  }
  return all;
}

}  // namespace

std::vector<std::byte> encode_hello(const Hello& hello) {
  std::vector<std::byte> out;
  for (char c : magic) out.push_back(static_cast<std::byte>(c));
  put(out, hello.version);
  put_name(out, hello.lab);
  put_name(out, hello.software);
  put_name(out, hello.experiment);
  put(out, hello.boot_id);
  put(out, hello.max_message_bytes);
  put_channels(out, hello.channels);
  return out;
}

std::vector<std::byte> encode_channels(const std::vector<ExportedChannel>& channels) {
  std::vector<std::byte> out;
  put_channels(out, channels);
  return out;
}

std::optional<std::vector<ExportedChannel>> read_channels(std::span<const std::byte> payload) {
  FieldReader in(payload);
  auto channels = take_channels(in);
  return channels && in.at_end() ? channels : std::nullopt;
}

std::optional<Hello> read_hello(std::span<const std::byte> payload) {
  FieldReader in(payload);
  if (in.take_text(magic.size()) != magic) return {};
  Hello hello;
  hello.version = in.take<std::uint16_t>();
  hello.lab = in.take_name();
  if (!in.good() || !hal::is_lab_name(hello.lab)) return {};
  if (hello.version != protocol_version) return hello;
  hello.software = in.take_name();
  hello.experiment = in.take_name();
  for (const std::string* text : {&hello.software, &hello.experiment})
    if (!text->empty() && !hal::is_label(*text)) return {};
  hello.boot_id = in.take<std::uint64_t>();
  hello.max_message_bytes = in.take<std::uint32_t>();
  auto channels = take_channels(in);
  if (!channels || !in.at_end() || hello.boot_id == 0) return {};
  hello.channels = std::move(*channels);
  return hello;
}

ExportedChannel exported(std::string_view channel) {
  ExportedChannel out{std::string(channel), 0};
  if (channel == hal::channel::world) out.type = static_cast<std::uint64_t>(world_t::getHash());
  if (channel == hal::channel::status) out.type = static_cast<std::uint64_t>(lab_status_t::getHash());
  return out;
}

std::optional<Refusal> why_refused(const Hello& ours, const Hello& theirs) {
  if (theirs.version != ours.version)
    return Refusal{"session.refused.version",
                   fmt::format("lab {} speaks protocol version {}, lab {} version {}; install the same arkmesh in both",
                               theirs.lab, theirs.version, ours.lab, ours.version)};
  if (theirs.experiment != ours.experiment)
    return Refusal{"session.refused.experiment",
                   fmt::format("gateway of {} belongs to experiment '{}', this one to '{}'; end that gateway, or set "
                               "shared.experiment alike",
                               theirs.lab, theirs.experiment, ours.experiment)};
  for (const ExportedChannel& own : ours.channels) {
    const auto same = std::ranges::find(theirs.channels, own.name, &ExportedChannel::name);
    if (same == theirs.channels.end() || own.type == 0 || same->type == 0 || own.type == same->type) continue;
    return Refusal{"session.refused.message_type",
                   fmt::format("messages on channel {} have another type in lab {} ({:016x}) than in lab {} ({:016x}); "
                               "install the same arkmesh in both",
                               own.name, theirs.lab, same->type, ours.lab, own.type)};
  }
  return {};
}

}  // namespace arkmesh::gateway
