// Arbitrary bytes as a peer's `world`: check, decode, and a gate that hears it. Nothing may crash, hang or take much
// memory.
#include <cstddef>
#include <cstdint>
#include <span>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/operator_command_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "hal/bus/bus.hpp"
#include "lab/exchange/period_gate.hpp"
#include "lab/exchange/world_message.hpp"

namespace {

template <class Message>
void decode_as(std::span<const std::byte> bytes) {
  Message message;
  (void)arkmesh::hal::decode(bytes, message);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace arkmesh::lab;
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  decode_as<arkmesh::lab_status_t>(bytes);
  decode_as<arkmesh::peers_t>(bytes);
  decode_as<arkmesh::operator_command_t>(bytes);
  WorldMessage message;
  if (!decode_world(bytes, message).empty()) return 0;
  PeriodGate gate({.lab = "a", .labs = {"a", "b"}, .slack = 1, .last_period = 100, .run_id = 1});
  LabState own;
  own.settings["run.seed"] = "1";
  gate.publish(own);
  gate.hear("b", message);
  // The same once more as a peer that means us.
  message.lab = "b";
  message.run_id = 2;
  message.acks["a"] = {1, -1};
  if (!message.window.empty() && message.window.front().period == 0) message.window.front().settings = own.settings;
  gate.hear("b", message);
  if (gate.may_merge(0)) gate.merge(0);
  (void)to_message(gate.message()).getEncodedSize();
  return 0;
}
