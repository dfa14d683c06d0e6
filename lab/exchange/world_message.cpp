#include "lab/exchange/world_message.hpp"

#include <algorithm>
#include <utility>

#include "hal/bus/bus.hpp"
#include "lab/behaviour_hash.hpp"

namespace arkmesh::lab {
namespace {

// Fields of ours beside a scenario's; none of them is there where every state has a payload of its own.
// [boundary at which robots and fields were made, 1 when they are here or 0 when they are left out]
constexpr const char* payload_field = "lab.payload";
// [number of the event within its period]
constexpr const char* event_field = "lab.event";
// As Growth::told() has it, in the newest state of the window. It is the message's, and not the state's.
constexpr const char* growth_field = "lab.grown";

using Fields = std::map<std::string, std::vector<std::int64_t>, std::less<>>;

Fields with_marks(const LabState& state) {
  Fields fields = state.fields;
  fields.emplace(payload_field, std::vector<std::int64_t>{static_cast<std::int64_t>(*state.made_at), state.carried});
  return fields;
}

// Takes it out of the fields.
std::vector<std::int64_t> take(LabState& state, const char* field) {
  auto taken = state.fields.extract(field);
  return taken ? std::move(taken.mapped()) : std::vector<std::int64_t>();
}

// Takes it out of the fields. False: it cannot be true.
bool take_payload_mark(LabState& state) {
  const auto mark = state.fields.find(payload_field);
  if (mark == state.fields.end()) return true;
  const std::vector<std::int64_t> values = std::move(mark->second);
  state.fields.erase(mark);
  if (values.size() != 2 || values[0] < 0 || values[0] > static_cast<std::int64_t>(state.period)) return false;
  state.made_at = static_cast<std::uint32_t>(values[0]);
  state.carried = values[1] == 1;
  return state.carried || (values[1] == 0 && state.robots.empty() && state.fields.empty());
}

// The event at the end of a window, if there is one, becomes one. False: it cannot be true.
bool take_event(WorldMessage& message) {
  for (std::size_t i = 0; i < message.window.size(); ++i) {
    LabState& state = message.window[i];
    const auto mark = state.fields.find(event_field);
    if (mark == state.fields.end()) continue;
    const std::vector<std::int64_t> values = std::move(mark->second);
    if (i + 1 < message.window.size() || values.size() != 1 || values[0] < 1 || values[0] > INT32_MAX) return false;
    state.fields.erase(mark);
    message.event = EarlyEvent{static_cast<std::uint32_t>(values[0]), std::move(state)};
    message.window.pop_back();
    return message.event->state.carried && !message.event->state.made_at;
  }
  return true;
}

}  // namespace

std::vector<shared_robot_t> to_messages(const std::vector<SharedRobot>& robots) {
  std::vector<shared_robot_t> out(robots.size());
  for (std::size_t i = 0; i < robots.size(); ++i) {
    out[i].robot = robots[i].robot;
    out[i].x_um = to_micro(robots[i].in_shared.x_m);
    out[i].y_um = to_micro(robots[i].in_shared.y_m);
    out[i].heading_urad = to_micro(robots[i].in_shared.heading_rad);
    out[i].led = static_cast<std::uint8_t>(robots[i].led);
  }
  return out;
}

std::vector<field_t> to_messages(const std::map<std::string, std::vector<std::int64_t>, std::less<>>& fields) {
  std::vector<field_t> out(fields.size());
  std::size_t i = 0;
  for (const auto& [name, values] : fields) {
    out[i].name = name;
    out[i].n = static_cast<std::int32_t>(values.size());
    out[i].values = values;
    ++i;
  }
  return out;
}

lab_state_t to_message(const LabState& state) {
  lab_state_t m;
  m.period = static_cast<std::int32_t>(state.period);
  m.behaviour = static_cast<std::int64_t>(state.hash);
  m.robots = to_messages(state.robots);
  m.n_robots = static_cast<std::int32_t>(m.robots.size());
  m.fields = to_messages(state.made_at ? with_marks(state) : state.fields);
  m.n_fields = static_cast<std::int32_t>(m.fields.size());
  for (const auto& [key, value] : state.settings) {
    m.settings.emplace_back();
    m.settings.back().key = key;
    m.settings.back().value = value;
  }
  m.n_settings = static_cast<std::int32_t>(m.settings.size());
  return m;
}

LabState from_message(const lab_state_t& m) {
  LabState state;
  state.period = static_cast<std::uint32_t>(m.period);
  state.hash = static_cast<std::uint64_t>(m.behaviour);
  state.robots.reserve(m.robots.size());
  for (const shared_robot_t& r : m.robots)
    state.robots.push_back({static_cast<hal::RobotId>(r.robot),
                            {r.x_um * 1e-6, r.y_um * 1e-6, r.heading_urad * 1e-6},
                            static_cast<hal::Led>(r.led)});
  for (const field_t& f : m.fields) state.fields.emplace(f.name, f.values);
  for (const setting_t& s : m.settings) state.settings.emplace(s.key, s.value);
  return state;
}

std::string_view decode_world(std::span<const std::byte> bytes, WorldMessage& message) {
  world_t m;
  if (const std::string_view why = hal::read_message(bytes, m); !why.empty()) return why;
  WorldMessage out;
  out.lab = m.lab;
  out.run_id = static_cast<std::uint64_t>(m.nonce);
  out.can_wait = m.can_wait;
  out.done = m.done;
  out.acks.reserve(m.acks.size());
  for (const ack_t& a : m.acks)
    out.acks.emplace_hint(out.acks.end(), a.peer, Ack{static_cast<std::uint64_t>(a.nonce), a.received});
  if (out.acks.size() != m.acks.size()) return "duplicate";
  for (const lab_state_t& s : m.window) {
    // What the values below cannot hold is refused here; what they mean is the gate's business.
    if (s.period < 0 || s.n_robots > 1'000'000) return "range";
    std::int32_t last = -1;
    for (const shared_robot_t& r : s.robots) {
      if (r.robot <= last || r.robot > static_cast<std::int32_t>(max_shared_robot) || r.led > 8) return "robot";
      last = r.robot;
    }
    out.window.push_back(from_message(s));
    if (out.window.back().fields.size() != s.fields.size() || out.window.back().settings.size() != s.settings.size())
      return "duplicate";
    if (auto growth = take(out.window.back(), growth_field); !growth.empty()) out.growth = std::move(growth);
    if (!take_payload_mark(out.window.back())) return "payload";
  }
  if (!take_event(out)) return "event";
  message = std::move(out);
  return {};
}

world_t to_message(const WorldMessage& message) {
  world_t m;
  m.lab = message.lab;
  m.nonce = static_cast<std::int64_t>(message.run_id);
  m.can_wait = message.can_wait;
  m.done = message.done;
  m.acks.reserve(message.acks.size());
  for (const auto& [peer, ack] : message.acks) {
    m.acks.emplace_back();
    m.acks.back().peer = peer;
    m.acks.back().nonce = static_cast<std::int64_t>(ack.run_id);
    m.acks.back().received = static_cast<std::int32_t>(ack.received);
  }
  m.n_acks = static_cast<std::int32_t>(m.acks.size());
  for (const LabState& s : message.window) m.window.push_back(to_message(s));
  if (!message.growth.empty() && !m.window.empty()) {
    std::vector<field_t>& fields = m.window.back().fields;
    field_t growth{
        .name = growth_field, .n = static_cast<std::int32_t>(message.growth.size()), .values = message.growth};
    fields.insert(std::ranges::upper_bound(fields, growth.name, {}, &field_t::name), std::move(growth));
    ++m.window.back().n_fields;
  }
  if (message.event) {
    LabState event = message.event->state;
    event.fields.emplace(event_field, std::vector<std::int64_t>{message.event->number});
    m.window.push_back(to_message(event));
  }
  m.n_states = static_cast<std::int32_t>(m.window.size());
  return m;
}

std::size_t longest_message(const RunConfig& run, const LabState& initial, bool can_wait) {
  WorldMessage message{.lab = run.lab};
  for (const std::string& peer : run.labs)
    if (peer != run.lab) message.acks[peer];
  // State 0 stays in it where labs do not wait for each other.
  std::size_t later = window_of(run.slack) - (can_wait ? 1 : 0);
  const auto empty = static_cast<std::size_t>(to_message(message).getEncodedSize());
  const auto bytes = [](const LabState& state) {
    return static_cast<std::size_t>(to_message(state)._getEncodedSizeNoHash());
  };
  LabState next = initial;
  next.settings.clear();
  if (!run.exchange.plain()) {  // their marks, and an event
    next.made_at = 0;
    ++later;
  }
  return empty + bytes(initial) + later * bytes(next);
}

}  // namespace arkmesh::lab
