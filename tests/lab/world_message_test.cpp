#include "lab/exchange/world_message.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "hal/bus/bus.hpp"

using namespace arkmesh;
using namespace arkmesh::lab;

namespace {

WorldMessage example() {
  WorldMessage m;
  m.lab = "shark";
  m.run_id = 0x1234567890abcdef;
  m.can_wait = true;
  m.acks["roark"] = {42, 7};
  for (std::uint32_t period : {0u, 1u}) {
    LabState s;
    s.period = period;
    s.hash = 0xfedcba9876543210 + period;
    for (hal::RobotId id = 0; id < 3; ++id) s.robots.push_back({id, {0.25 * id, -0.125, 1.5}, hal::Led::green});
    s.fields["team"] = {0, 1, 2, 3};
    s.fields["active"] = {1, 1, 0, 1};
    if (period == 0) s.settings["gate.slack"] = "0";
    m.window.push_back(s);
  }
  return m;
}

template <class Message>
std::vector<std::byte> as_bytes(const Message& message) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

lab_status_t status_example() {
  lab_status_t m{};
  m.lab = "shark";
  m.state = "running";
  m.kept_still = "operator";
  m.not_standing.resize(3);
  m.n_not_standing = 3;
  m.counters.resize(2);
  m.counters[0].name = "a.b";
  m.counters[1].name = "c.d";
  m.n_counters = 2;
  return m;
}

peers_t peers_example() {
  peers_t m{};
  m.lab = "shark";
  m.peers.resize(1);
  m.peers[0].lab = "roark";
  m.peers[0].why = "connected";
  m.peers[0].version = "0.1.0";
  m.peers[0].channels.resize(1);
  m.peers[0].channels[0].channel = "roark/world";
  m.peers[0].n_channels = 1;
  m.peers[0].n_counters = 0;
  m.n_peers = 1;
  m.n_counters = 0;
  return m;
}

// Why a message of this type is refused; empty: it is not.
template <class Message>
std::string_view refusal(std::span<const std::byte> bytes) {
  Message message;
  return hal::read_message(bytes, message);
}

}  // namespace

TEST_CASE("a world message survives the network") {
  // Proves that what others merge is what the owner published, to the micrometre.
  WorldMessage back;
  REQUIRE(decode_world(as_bytes(to_message(example())), back) == "");
  const WorldMessage m = example();
  CHECK(back.lab == m.lab);
  CHECK(back.run_id == m.run_id);
  CHECK(back.acks.at("roark").run_id == 42);
  CHECK(back.acks.at("roark").received == 7);
  REQUIRE(back.window.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(back.window[i].period == m.window[i].period);
    CHECK(back.window[i].hash == m.window[i].hash);
    CHECK(back.window[i].fields == m.window[i].fields);
    CHECK(back.window[i].settings == m.window[i].settings);
    REQUIRE(back.window[i].robots.size() == 3);
    CHECK(back.window[i].robots[2].in_shared.x_m == doctest::Approx(0.5));
    CHECK(back.window[i].robots[2].led == hal::Led::green);
  }
}

TEST_CASE("every truncation and every trailing byte is refused") {
  // Proves that the checkers accept exactly one message and never look past its end.
  const auto refused = [](std::vector<std::byte> bytes, auto check) {
    REQUIRE(check(bytes) == "");
    for (std::size_t n = 0; n < bytes.size(); ++n) CHECK(check(std::span(bytes).first(n)) != "");
    bytes.push_back(std::byte{0});
    CHECK(check(bytes) == "trailing");
  };
  refused(as_bytes(to_message(example())), refusal<world_t>);
  refused(as_bytes(status_example()), refusal<lab_status_t>);
  refused(as_bytes(peers_example()), refusal<peers_t>);
}

TEST_CASE("forged counts are refused before anything is decoded") {
  // Proves that no count of a message is trusted: at every offset, the four values that broke the generated decoder.
  const auto forge = [](const std::vector<std::byte>& bytes, auto read) {
    for (const std::int32_t lie : {-1, 0, 0x7fffffff, 1 << 27})
      for (std::size_t at = 0; at + 4 <= bytes.size(); ++at) {
        std::vector<std::byte> forged = bytes;
        for (int i = 0; i < 4; ++i)
          forged[at + static_cast<std::size_t>(i)] =
              static_cast<std::byte>(static_cast<std::uint32_t>(lie) >> (24 - 8 * i));
        CHECK(read(forged) != "undecodable");  // what passes the check decodes, within the bytes it has
      }
  };
  forge(as_bytes(to_message(example())), refusal<world_t>);
  forge(as_bytes(status_example()), refusal<lab_status_t>);
  forge(as_bytes(peers_example()), refusal<peers_t>);
}

TEST_CASE("values that no robot or field can have are refused by name") {
  // Proves that what the types of a state cannot hold never becomes a state.
  const auto why = [](auto change) {
    world_t m = to_message(example());
    change(m);
    WorldMessage out;
    return std::string(decode_world(as_bytes(m), out));
  };
  CHECK(why([](world_t&) {}) == "");
  CHECK(why([](world_t& m) { m.window[0].period = -1; }) == "range");
  CHECK(why([](world_t& m) { m.window[1].robots[1].robot = 0; }) == "robot");
  CHECK(why([](world_t& m) { m.window[1].robots[2].robot = 70000; }) == "robot");
  CHECK(why([](world_t& m) { m.window[1].robots[0].led = 9; }) == "robot");
  CHECK(why([](world_t& m) { m.window[1].fields[1].name = m.window[1].fields[0].name; }) == "duplicate");
  CHECK(why([](world_t& m) {
          m.acks.push_back(m.acks[0]);
          m.n_acks = 2;
        }) == "duplicate");
  CHECK(why([](world_t& m) { m.lab = std::string(5000, 'x'); }) == "text");
}
