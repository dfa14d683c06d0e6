// The `world` message as values, and its way to and from bytes.
#pragma once

#include <boost/container/flat_map.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arkmesh/world_t.hpp"
#include "lab/exchange/lab_state.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::lab {

// Labs tell each other of robots with ids to this.
inline constexpr hal::RobotId max_shared_robot = 0xffff;

// Own states per message: the fewest that cannot deadlock.
constexpr std::uint32_t window_of(std::uint32_t slack) {
  return 2 * slack + 2;
}

// How far a lab has heard a peer.
struct Ack {
  std::uint64_t run_id = 0;    // the peer's run id as last heard; 0 never
  std::int64_t received = -1;  // highest period received without gap; -1 none
};

// What became so before a boundary, where exchange goes by events and nobody waits: a state of the period to come,
// without settings, and its number within that period.
struct EarlyEvent {
  std::uint32_t number = 0;
  LabState state;
};

struct WorldMessage {
  std::string lab;
  std::uint64_t run_id = 0;
  bool can_wait = true;
  bool done = false;
  boost::container::flat_map<std::string, Ack, std::less<>> acks;
  std::vector<LabState> window;  // ascending period
  std::optional<EarlyEvent> event;
  std::vector<std::int64_t> growth;  // Growth::told()
};

lab_state_t to_message(const LabState& state);
LabState from_message(const lab_state_t& message);
std::vector<shared_robot_t> to_messages(const std::vector<SharedRobot>& robots);
std::vector<field_t> to_messages(const std::map<std::string, std::vector<std::int64_t>, std::less<>>& fields);

// Checks sizes, decodes. Returns an empty text, or the reason for refusing in one word; `message` is then unchanged.
std::string_view decode_world(std::span<const std::byte> bytes, WorldMessage& message);
world_t to_message(const WorldMessage& message);
// Length in bytes of the longest message of a lab whose states are all as long as `initial`, its state 0.
std::size_t longest_message(const RunConfig& run, const LabState& initial, bool can_wait);

}  // namespace arkmesh::lab
