// What two gateways tell each other first, and whether they can work together. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::gateway {

inline constexpr std::uint16_t protocol_version = 3;
// A hello is never longer; nothing longer is read from a peer that has not introduced itself.
inline constexpr std::size_t max_hello_bytes = 16'384;
inline constexpr std::size_t max_hello_channels = 256;

struct ExportedChannel {
  std::string name;
  std::uint64_t type = 0;  // LCM fingerprint of the messages on it; 0: unknown to the gateway
};

struct Hello {
  std::uint16_t version = protocol_version;
  std::string lab;
  std::string software = ARKMESH_VERSION;  // the arkmesh that speaks; for people
  std::string experiment;                  // shared.experiment; both must have the same
  std::uint64_t boot_id = 0;               // grows with each start of that lab's gateway
  std::uint32_t max_message_bytes = 0;     // longer ones are not wanted
  std::vector<ExportedChannel> channels;   // each once; nothing else will come
};

// The payload of a hello frame.
std::vector<std::byte> encode_hello(const Hello& hello);
// Nothing when it is no hello. Of another protocol version only `version` and `lab` are read: their place never
// changes.
std::optional<Hello> read_hello(std::span<const std::byte> payload);

// The payload of a frame that replaces the hello's list of channels; the hello ends with it, too.
std::vector<std::byte> encode_channels(const std::vector<ExportedChannel>& channels);
std::optional<std::vector<ExportedChannel>> read_channels(std::span<const std::byte> payload);

// The channel with its fingerprint when it is one that every lab exports (`world`, `status`).
ExportedChannel exported(std::string_view channel);

// Why the two cannot work together: a counter name and a sentence for people. Nothing when they can.
struct Refusal {
  std::string counter;
  std::string sentence;
};
std::optional<Refusal> why_refused(const Hello& ours, const Hello& theirs);

}  // namespace arkmesh::gateway
