// Who else is on our LCM port, and who was there first.
#include "gateway/port_monitor.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"

namespace arkmesh::gateway {
namespace {

peers_t peers_of(const std::string& lab, std::int64_t boot_id) {
  peers_t message;
  message.lab = lab;
  message.boot_id = boot_id;
  message.n_peers = message.n_counters = 0;
  return message;
}

lab_status_t status_of(const std::string& lab) {
  lab_status_t message{};
  message.lab = lab;
  message.nonce = 5;
  return message;
}

struct WatchedPort {
  hal::Bus bus{"memq://"};
  PortMonitor watch{bus, "shark", 100};
  template <class Message>
  void hear(const std::string& channel, const Message& message) {
    bus.publish(channel, message);
    bus.drain();
  }
};

TEST_CASE("our own messages are no neighbour") {
  // Our lab, our own gateway and what comes from peers do not disturb.
  WatchedPort shark;
  shark.watch.ask();
  shark.hear("peers", peers_of("shark", 100));
  shark.hear("status", status_of("shark"));
  shark.hear("roark/status", status_of("roark"));
  CHECK(shark.watch.earlier().empty());
  CHECK_FALSE(shark.watch.heard_other());
}

TEST_CASE("another lab on the port is named") {
  // Its status or its gateway's older `peers` is reason enough, with what to do.
  for (const bool by_status : {true, false}) {
    WatchedPort shark;
    if (by_status)
      shark.hear("status", status_of("roark"));
    else
      shark.hear("peers", peers_of("roark", 99));
    CHECK(shark.watch.earlier() ==
          "bus memq://: lab roark uses this LCM port as well; give each lab its own port in bus.url");
    CHECK(shark.watch.counters()["bus.other_lab.roark"] == 1);
  }
}

TEST_CASE("of two gateways the older stays") {
  // The newer one learns of the older; the older one only knows that it has to make itself heard.
  WatchedPort newer;
  newer.hear("peers", peers_of("shark", 99));
  CHECK(newer.watch.earlier() == "bus memq://: another gateway of lab shark runs already; stop it first");
  WatchedPort older;
  older.hear("peers", peers_of("shark", 101));
  older.hear("peers", peers_of("roark", 101));
  CHECK(older.watch.earlier().empty());
  CHECK(older.watch.heard_other());
  CHECK_FALSE(older.watch.heard_other());
  CHECK(older.watch.counters()["bus.second_gateway"] == 1);
  CHECK(older.watch.counters()["bus.other_lab.roark"] == 1);
}

TEST_CASE("what is no such message is ignored and counted") {
  // Every truncation before the sender's end, another fingerprint, forged lengths and illegal names.
  WatchedPort shark;
  std::vector<std::byte> bytes;
  {
    const auto copy =
        shark.bus.subscribe("copy", [&](std::string_view, auto heard) { bytes.assign(heard.begin(), heard.end()); });
    shark.hear("copy", peers_of("roark", 99));
  }
  REQUIRE(bytes.size() > 26);
  std::uint64_t bad = 0;
  const auto ignored = [&](std::span<const std::byte> part) {
    shark.bus.publish("peers", part);
    shark.bus.drain();
    CHECK(shark.watch.counters()["bus.ignored.peers"] == ++bad);
  };
  for (std::size_t size = 0; size < 8 + 4 + 6 + 8; ++size) ignored(std::span(bytes).first(size));
  auto forged = bytes;
  forged[0] ^= std::byte{1};
  ignored(forged);
  for (const std::size_t at : {8u, 9u, 10u, 11u}) {
    forged = bytes;
    forged[at] = std::byte{0xff};
    ignored(forged);
  }
  forged = bytes;
  forged[12] = std::byte{'/'};
  ignored(forged);
  CHECK(shark.watch.earlier().empty());
  shark.hear("status", peers_of("roark", 99));
  CHECK(shark.watch.counters()["bus.ignored.status"] == 1);
}

}  // namespace
}  // namespace arkmesh::gateway
