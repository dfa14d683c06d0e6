// Who may connect, and what becomes of those who may not: strangers, other versions, doubles, garbage, silence.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "gateway/links/connections.hpp"
#include "hal/config/config.hpp"
#include "hal/random.hpp"
#include "tests/support/network/raw_peer.hpp"
#include "tests/support/network/tcp_bench.hpp"

namespace arkmesh::gateway {
namespace {

using namespace tests;
using boost::asio::ip::tcp;

// The gateway of lab shark, which expects roark to connect.
struct Listening {
  boost::asio::io_context io;
  std::vector<std::string> notices;
  std::unique_ptr<Connections> node;
  std::unique_ptr<Link> link;
  std::vector<std::string> whys;  // of each change
  std::vector<std::string> arrived;

  explicit Listening(std::uint64_t boot_id = 100) {
    TcpSettings settings = tcp_settings("shark", boot_id);
    settings.listen = "127.0.0.1:0";
    settings.notice = [this](const std::string& sentence) { notices.push_back(sentence); };
    node = std::make_unique<Connections>(io, std::move(settings));
    link = node->link("roark");
    link->start({.arrived = [this](std::string_view channel, auto) { arrived.emplace_back(channel); },
                 .changed = [this](bool, std::string_view why) { whys.emplace_back(why); }});
  }
  std::unique_ptr<RawPeer> peer() {
    auto made = std::make_unique<RawPeer>(io, node->listening().port());
    made->listen();
    return made;
  }
  // A peer that was let in.
  std::unique_ptr<RawPeer> accepted_peer(std::uint64_t boot_id = 7) {
    auto made = peer();
    made->say(hello(boot_id));
    made->beat();
    REQUIRE(run_until(
        io, [&] { return made->heartbeats > 0 && link->stats().up && link->stats().peer_boot_id == boot_id; }));
    return made;
  }
  static Hello hello(std::uint64_t boot_id = 7) {
    Hello out;
    out.lab = "roark";
    out.experiment = "dhtf";
    out.boot_id = boot_id;
    out.max_message_bytes = 1 << 20;
    out.channels = {exported("world"), exported("status")};
    return out;
  }
  std::uint64_t count(std::string_view name) const { return link->stats().counters[name]; }
};

TEST_CASE("a hello is answered, and the link is up when both accepted") {
  // The listening side says who it is before it knows whom it talks to, and counts itself connected only once the peer
  // goes on.
  Listening shark;
  const auto peer = shark.peer();
  REQUIRE(run_until(shark.io, [&] { return peer->hello.has_value(); }));
  CHECK(peer->hello->lab == "shark");
  CHECK(peer->hello->boot_id == 100);
  CHECK(peer->hello->channels.size() == 3);
  peer->say(Listening::hello());
  REQUIRE(run_until(shark.io, [&] { return peer->heartbeats == 1; }));
  CHECK_FALSE(shark.link->stats().up);
  peer->say(encode_message("world", {}));
  REQUIRE(run_until(shark.io, [&] { return shark.link->stats().up; }));
  CHECK(shark.arrived == std::vector<std::string>{"world"});
}

TEST_CASE("a peer of another protocol version is refused in words") {
  // The listening side tells the peer and itself, naming both versions, and forgets the connection.
  Listening shark;
  const auto peer = shark.peer();
  Hello later = Listening::hello();
  later.version = 9;
  peer->say(later);
  const std::string why = fmt::format(
      "lab roark speaks protocol version 9, lab shark version {}; install the same arkmesh in both", protocol_version);
  REQUIRE(run_until(shark.io, [&] { return peer->closed; }));
  CHECK(peer->bye == why);
  CHECK(shark.link->stats().why == why);
  CHECK(shark.count("session.refused.version") == 1);
  CHECK_FALSE(shark.link->stats().up);
}

TEST_CASE("a peer of another experiment is refused in words") {
  // A gateway that was left running is named with what it belongs to, on both sides.
  Listening shark;
  const auto peer = shark.peer();
  Hello forgotten = Listening::hello();
  forgotten.experiment = "cre";
  peer->say(forgotten);
  const std::string why =
      "gateway of roark belongs to experiment 'cre', this one to 'dhtf'; end that gateway, or set shared.experiment "
      "alike";
  REQUIRE(run_until(shark.io, [&] { return peer->closed; }));
  CHECK(peer->bye == why);
  CHECK(shark.link->stats().why == why);
  CHECK(shark.count("session.refused.experiment") == 1);
}

TEST_CASE("a peer with other message types is refused in words") {
  // The channel whose messages differ is named on both sides.
  Listening shark;
  const auto peer = shark.peer();
  Hello other = Listening::hello();
  other.channels[1].type ^= 1;
  peer->say(other);
  REQUIRE(run_until(shark.io, [&] { return peer->closed; }));
  CHECK(peer->bye.find("messages on channel status have another type in lab roark") == 0);
  CHECK(shark.link->stats().why == peer->bye);
  CHECK(shark.count("session.refused.message_type") == 1);
}

TEST_CASE("an unexpected lab is refused by name") {
  // A lab that is no peer, and one that takes our own name, are told so; the operator reads it once.
  Listening shark;
  for (int i = 0; i < 2; ++i) {
    const auto peer = shark.peer();
    Hello stranger = Listening::hello();
    stranger.lab = "lynx";
    peer->say(stranger);
    REQUIRE(run_until(shark.io, [&] { return peer->closed; }));
    CHECK(peer->bye == "lab shark does not expect a connection from lab lynx");
  }
  CHECK(shark.notices == std::vector<std::string>{"lab shark does not expect a connection from lab lynx"});
  CHECK(shark.node->counters()["session.refused.unknown_lab"] == 2);
  const auto peer = shark.peer();
  Hello own = Listening::hello();
  own.lab = "shark";
  peer->say(own);
  REQUIRE(run_until(shark.io, [&] { return peer->closed; }));
  CHECK(peer->bye == "another gateway also calls itself shark");
}

TEST_CASE("the connecting side judges as well") {
  // Who connects refuses a wrong lab, another version and other types, says so once, and tries again with pauses.
  boost::asio::io_context io;
  tcp::acceptor acceptor(io, tcp::endpoint(boost::asio::ip::address_v4::loopback(), 0));
  Hello answer = Listening::hello();
  std::string expected;
  SUBCASE("lab") {
    answer.lab = "lynx";
    expected = "there is lab lynx, not lab roark";
  }
  SUBCASE("version") {
    answer.version = 1;
    expected = fmt::format("lab roark speaks protocol version 1, lab shark version {}", protocol_version);
  }
  SUBCASE("experiment") {
    answer.experiment = "cre";
    expected = "gateway of roark belongs to experiment 'cre', this one to 'dhtf'";
  }
  SUBCASE("type") {
    answer.channels[0].type = 5;
    expected = "messages on channel world have another type";
  }
  std::vector<std::unique_ptr<RawPeer>> peers;
  std::function<void()> accept = [&] {
    acceptor.async_accept([&](auto error, tcp::socket socket) {
      if (error) return;
      peers.push_back(std::make_unique<RawPeer>(std::move(socket)));
      peers.back()->listen();
      peers.back()->say(answer);
      accept();
    });
  };
  accept();
  Connections node(io, tcp_settings("shark", 3));
  const auto link = node.link("roark", "127.0.0.1:" + std::to_string(acceptor.local_endpoint().port()));
  std::vector<std::string> whys;
  link->start({.arrived = [](auto, auto) {},
               .changed =
                   [&](bool up, std::string_view why) {
                     CHECK_FALSE(up);
                     whys.emplace_back(why);
                   }});
  REQUIRE(run_until(io, [&] { return peers.size() == 4; }));
  CHECK(whys.size() == 1);
  CHECK(whys.front().find(expected) != std::string::npos);
  CHECK(peers[0]->bye == whys.front());
  CHECK(peers[0]->closed);
  acceptor.close();
}

TEST_CASE("of two gateways of one lab the newer stays") {
  // A restarted gateway takes its own old connection's place; an older one is refused while a newer is connected.
  Listening shark;
  const auto first = shark.accepted_peer(50);
  const auto second = shark.accepted_peer(60);
  REQUIRE(run_until(shark.io, [&] { return first->closed; }));
  CHECK(first->bye == "replaced by a newer connection of lab roark");
  CHECK(shark.count("session.replaced") == 1);
  // Whoever says so, and on this machine anybody can, does not do it unseen.
  CHECK(shark.notices.size() == 1);
  CHECK(shark.notices.back().starts_with("a gateway of lab roark that started later replaced the connected one"));
  const auto third = shark.peer();
  third->say(Listening::hello(55));
  REQUIRE(run_until(shark.io, [&] { return third->closed; }));
  CHECK(third->bye == "a gateway of lab roark that started later is already connected");
  CHECK(shark.count("session.refused.older_boot") == 1);
  CHECK(shark.link->stats().up);
  CHECK(shark.link->stats().peer_boot_id == 60);
  // The same gateway again, as after a connection that only the other side saw break.
  const auto again = shark.accepted_peer(60);
  REQUIRE(run_until(shark.io, [&] { return second->closed; }));
  CHECK(shark.count("session.replaced") == 2);
}

TEST_CASE("garbage on the port is closed, counted, and disturbs nobody") {
  // HTTP, noise and oversized frames end their own connection only; the real peer is served meanwhile.
  Listening shark;
  const auto peer = shark.accepted_peer();
  hal::RandomStream random(5, "garbage");
  std::string noise(100'000, '\0');
  for (char& c : noise) c = static_cast<char>(random.next());
  for (const std::string& garbage :
       {std::string("GET / HTTP/1.1\r\nHost: shark\r\n\r\n"), noise, std::string(16, '\0'), std::string(16, '\xff')}) {
    const auto stranger = shark.peer();
    stranger->say(garbage);
    REQUIRE(run_until(shark.io, [&] { return stranger->closed; }));
  }
  CHECK(shark.node->counters()["session.closed.bad_header"] == 4);
  CHECK(shark.notices.size() == 1);
  peer->say(encode_message("world", {}));
  REQUIRE(run_until(shark.io, [&] { return shark.arrived.size() == 1; }));
}

TEST_CASE("a frame of 4 GiB costs nothing") {
  // A well-formed header that claims 4 GiB, before and after the hello, closes the connection without memory being
  // asked for.
  std::vector<std::byte> header(frame_header_bytes, std::byte{0xff});
  for (std::size_t i = 4; i < 7; ++i) header[i] = std::byte{0};
  header[7] = std::byte{2};
  const std::uint32_t crc = crc32c(std::span(header).first(8));
  for (std::size_t i = 0; i < 4; ++i) header[8 + i] = static_cast<std::byte>(crc >> (24 - 8 * i));
  Listening shark;
  const auto stranger = shark.peer();
  stranger->say(header);
  REQUIRE(run_until(shark.io, [&] { return stranger->closed; }));
  CHECK(shark.node->counters()["session.closed.bad_length"] == 1);
  const auto peer = shark.accepted_peer();
  peer->say(header);
  REQUIRE(run_until(shark.io, [&] { return peer->closed; }));
  CHECK(shark.count("session.closed.bad_length") == 1);
  CHECK(shark.link->stats().why == "received a frame of 4294967295 bytes; the limit is 16384");
}

TEST_CASE("what a peer may say only after its hello, and only once") {
  // Messages before the hello, a malformed hello, a second hello and a message without channel each close the
  // connection.
  Listening shark;
  const auto closed_by = [&](RawPeer& peer) { REQUIRE(run_until(shark.io, [&] { return peer.closed; })); };
  auto peer = shark.peer();
  peer->say(encode_message("world", {}));
  closed_by(*peer);
  CHECK(shark.node->counters()["session.closed.no_hello"] == 1);
  peer = shark.peer();
  peer->say(FrameKind::hello, std::as_bytes(std::span("ARKMESH\n", 8)));
  closed_by(*peer);
  CHECK(shark.node->counters()["session.closed.bad_hello"] == 1);
  peer = shark.accepted_peer();
  peer->say(Listening::hello());
  closed_by(*peer);
  CHECK(shark.count("session.closed.second_hello") == 1);
  peer = shark.accepted_peer();
  peer->say(FrameKind::message);
  closed_by(*peer);
  CHECK(shark.count("session.closed.bad_message") == 1);
  peer = shark.accepted_peer();
  peer->say(FrameKind::heartbeat);
  closed_by(*peer);
  CHECK(shark.count("session.closed.bad_heartbeat") == 1);
  peer = shark.accepted_peer();
  peer->say(FrameKind::ack, encode(Acknowledgement{1, 100}));
  closed_by(*peer);
  CHECK(shark.count("session.closed.bad_ack") == 1);
  peer = shark.accepted_peer();
  peer->say(FrameKind::channels, std::as_bytes(std::span("\xff\xff", 2)));
  closed_by(*peer);
  CHECK(shark.count("session.closed.bad_channels") == 1);
  CHECK(shark.arrived.empty());
  // Of parts no more is kept than of a message.
  peer = shark.accepted_peer();
  const auto part = encode_frame(FrameKind::part, std::vector<std::byte>(max_frame_payload_bytes));
  for (int i = 0; i < 65; ++i) peer->say(part);
  closed_by(*peer);
  CHECK(shark.count("session.closed.bad_length") == 1);
  peer = shark.accepted_peer();
  peer->say(FrameKind::bye, std::as_bytes(std::span("\x1b[31mred\n", 9)));
  closed_by(*peer);
  CHECK(shark.link->stats().why == "the peer says: ?[31mred?");
}

TEST_CASE("a channel that the hello did not list is refused") {
  // Such a message is counted and forgotten; the connection stays.
  Listening shark;
  const auto peer = shark.accepted_peer();
  peer->say(encode_message("surprise", {}));
  peer->say(encode_message("world", {}));
  REQUIRE(run_until(shark.io, [&] { return shark.arrived.size() == 1; }));
  CHECK(shark.arrived.front() == "world");
  CHECK(shark.count("received.refused.unlisted_channel") == 1);
}

TEST_CASE("nobody is met before a link starts") {
  // The port is open and peers may come, but they wait without a word until the first link starts.
  boost::asio::io_context io;
  TcpSettings settings = tcp_settings("shark", 100);
  settings.listen = "127.0.0.1:0";
  Connections node(io, std::move(settings));
  const auto link = node.link("roark");
  RawPeer peer(io, node.listening().port());
  peer.listen();
  peer.say(Listening::hello());
  peer.beat();
  // Longer than the node's own timer takes.
  const auto begun = std::chrono::steady_clock::now();
  REQUIRE(run_until(io, [&] { return std::chrono::steady_clock::now() - begun > std::chrono::milliseconds(120); }));
  CHECK_FALSE(peer.hello);
  CHECK_FALSE(peer.closed);
  link->start({.arrived = [](auto, auto) {}, .changed = [](auto, auto) {}});
  REQUIRE(run_until(io, [&] { return link->stats().up && peer.heartbeats > 0; }));
  CHECK(peer.hello->lab == "shark");
}

TEST_CASE("who says nothing is closed in time") {
  // A silent connection, and one that says hello byte by byte, are closed when the time for a hello is over.
  Listening shark;
  const auto silent = shark.peer(), slow = shark.peer();
  const auto begun = std::chrono::steady_clock::now();
  const auto hello = encode_frame(FrameKind::hello, encode_hello(Listening::hello()));
  std::size_t said = 0;
  auto next = begun;
  REQUIRE(run_until(shark.io, [&] {
    if (const auto now = std::chrono::steady_clock::now(); now >= next && said < 20 && !slow->closed) {
      slow->say(std::span(hello).subspan(said++, 1));
      next = now + std::chrono::milliseconds(50);
    }
    return silent->closed && slow->closed;
  }));
  const auto took = std::chrono::steady_clock::now() - begun;
  CHECK(took >= short_times().hello);
  CHECK(said > 1);
  CHECK(shark.node->counters()["session.closed.no_hello"] == 2);
}

TEST_CASE("many silent connections do not keep the peer out") {
  // Of more than 16 connections without a hello the oldest give way, so that who says hello at once always gets in.
  Listening shark;
  std::vector<std::unique_ptr<RawPeer>> silent;
  for (int i = 0; i < 40; ++i) silent.push_back(shark.peer());
  REQUIRE(run_until(shark.io, [&] { return shark.node->counters()["session.closed.too_many_pending"] == 24; }));
  const auto peer = shark.accepted_peer();
  CHECK(shark.link->stats().up);
  REQUIRE(run_until(shark.io, [&] { return silent[0]->closed && silent[23]->closed; }));
}

TEST_CASE("a message that the peer does not want stays here") {
  // The limit in the peer's hello counts: what is longer is counted and dropped, also when it waited already; the rest
  // goes.
  Listening shark;
  shark.link->offer({"world", Delivery::latest}, "world", std::vector<std::byte>(5000));
  const auto peer = shark.peer();
  Hello modest = Listening::hello();
  modest.max_message_bytes = 1000;
  peer->say(modest);
  peer->beat();
  REQUIRE(run_until(shark.io, [&] { return shark.link->stats().up; }));
  shark.link->offer({"events", Delivery::ordered}, "events", std::vector<std::byte>(1000));
  shark.link->offer({"events", Delivery::ordered}, "events", std::vector<std::byte>(2000));
  shark.link->offer({"events", Delivery::ordered}, "events", std::vector<std::byte>(10));
  REQUIRE(run_until(shark.io, [&] { return peer->messages.size() == 2; }));
  CHECK(peer->messages[0].size() == 1007);
  CHECK(peer->messages[1].size() == 17);
  CHECK(shark.count("outbox.refused.too_big.world") == 1);
  CHECK(shark.count("outbox.refused.too_big.events") == 1);
  CHECK(shark.link->stats().up);
}

TEST_CASE("a port in use and an address of another machine are refused in words") {
  // One sentence with the port or the address, and what to do.
  Listening shark;
  const std::string port = std::to_string(shark.node->listening().port());
  TcpSettings settings = tcp_settings("roark", 1);
  settings.listen = "127.0.0.1:" + port;
  CHECK_THROWS_WITH_AS(Connections(shark.io, settings),
                       ("TCP port " + port +
                        " of 127.0.0.1 is in use by another program; stop it (ss -ltnp shows it) or give "
                        "gateway.listen another port")
                           .c_str(),
                       std::runtime_error);
  for (const char* elsewhere :
       {"0.0.0.0:7830", "10.0.0.1:7830", "192.168.1.5:80", "[::]:7830", "[2001:db8::1]:7830", "example.org:7830"}) {
    settings.listen = elsewhere;
    CHECK_THROWS_AS(Connections(shark.io, settings), hal::ConfigError);
    CHECK_THROWS_AS((void)shark.node->link("lynx", elsewhere), hal::ConfigError);
  }
}

}  // namespace
}  // namespace arkmesh::gateway
