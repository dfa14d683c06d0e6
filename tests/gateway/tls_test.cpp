// Links over TLS: who is let in, who is not and why, and that a connection obeys what `arkmesh keys` says later.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "gateway/links/connections.hpp"
#include "tests/support/network/raw_peer.hpp"
#include "tests/support/network/tcp_bench.hpp"
#include "tests/support/network/test_keys.hpp"

namespace arkmesh::gateway {
namespace {

using namespace tests;
using boost::asio::ip::tcp;

// One lab's gateway.
struct TlsEnd {
  std::vector<std::string> notices, arrived;
  std::unique_ptr<Connections> node;
  std::unique_ptr<Link> link;

  TlsEnd(boost::asio::io_context& io, const std::string& lab, std::shared_ptr<TlsKeys> keys,
         const std::string& listen = "") {
    TcpSettings settings = tcp_settings(lab, 100);
    settings.listen = listen;
    settings.keys = std::move(keys);
    settings.notice = [this](const std::string& sentence) { notices.push_back(sentence); };
    node = std::make_unique<Connections>(io, std::move(settings));
  }
  void expect(const std::string& peer) { start(node->link(peer)); }
  void connect(const std::string& peer, const TlsEnd& to, const std::string& host = "127.0.0.1") {
    start(node->tls_link(peer, fmt::format("{}:{}", host, to.node->listening().port())));
  }
  void start(std::unique_ptr<Link> made) {
    link = std::move(made);
    link->start({.arrived =
                     [this](std::string_view, auto bytes) {
                       arrived.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                     },
                 .changed = [](bool, std::string_view) {}});
  }
  bool up() const { return link->stats().up; }
  // Of the link and of connections that belong to none.
  std::uint64_t count(std::string_view name) const {
    return (link ? link->stats().counters[name] : 0) + node->counters()[name];
  }
  bool noticed(std::string_view text) const {
    for (const std::string& notice : notices)
      if (notice.find(text) != std::string::npos) return true;
    return false;
  }
};

// Shark listens and expects roark, who connects; both trust each other.
struct TlsPair {
  TestKeys keys;
  boost::asio::io_context io;
  std::unique_ptr<TlsEnd> shark, roark;

  TlsPair() { keys.join("shark", "roark"); }
  void start(const std::string& host = "127.0.0.1") {
    shark = std::make_unique<TlsEnd>(io, "shark", keys.tls("shark"), "tls://127.0.0.1:0");
    shark->expect("roark");
    roark = std::make_unique<TlsEnd>(io, "roark", keys.tls("roark"));
    roark->connect("shark", *shark, host);
  }
  bool both_up() {
    return run_until(
        io, [&] { return shark->up() && roark->up(); }, std::chrono::seconds(300));
  }
  template <class Condition>
  bool comes_to(Condition condition) {
    return run_until(io, condition, std::chrono::seconds(300));
  }
};

TEST_CASE("two labs that trust each other meet over TLS") {
  // Small and large messages cross both ways, unchanged and in order.
  TlsPair pair;
  pair.start();
  REQUIRE(pair.both_up());
  std::vector<std::string> said;
  for (int i = 0; i < 200; ++i) said.emplace_back(i % 20 == 7 ? 100'000 : 100, static_cast<char>('a' + i % 26));
  for (const std::string& each : said) {
    pair.shark->link->offer({"events", Delivery::ordered}, "events", std::as_bytes(std::span(each)));
    pair.roark->link->offer({"events", Delivery::ordered}, "events", std::as_bytes(std::span(each)));
  }
  REQUIRE(pair.comes_to([&] { return pair.shark->arrived.size() == 200 && pair.roark->arrived.size() == 200; }));
  CHECK(pair.shark->arrived == said);
  CHECK(pair.roark->arrived == said);
}

TEST_CASE("a host is looked up by name, and the loop turns meanwhile") {
  // A name that there is, and one that there is not: its sentence names it.
  TlsPair pair;
  pair.start("localhost");
  CHECK(pair.both_up());
  TlsEnd lost(pair.io, "roark", pair.keys.tls("roark"));
  lost.start(lost.node->tls_link("shark", "nowhere.invalid:7444"));
  REQUIRE(pair.comes_to([&] { return lost.count("session.failed.connect") > 0; }));
  CHECK(lost.link->stats().why.find("nowhere.invalid:7444: ") == 0);
}

TEST_CASE("certificates that are not let in") {
  // Each with its counter, and in words for both sides; nothing of the lab is said before.
  TlsPair pair;
  std::string here, there, words;
  SUBCASE("unknown to who listens") {
    pair.keys.of("shark").revoke("roark");
    std::filesystem::remove_all(pair.keys.of("shark").path() / "revoked");
    here = "session.refused.certificate_unknown", there = "session.failed.not_trusted_there";
    words = "it says it is lab roark, fingerprint " + fingerprint(pair.keys.of("roark").own("roark").certificate.pin);
  }
  SUBCASE("revoked by who listens") {
    pair.keys.of("shark").revoke("roark");
    here = "session.refused.certificate_revoked", there = "session.failed.revoked_there";
    words = "its certificate was revoked here";
  }
  SUBCASE("unknown to who connects") {
    std::filesystem::remove_all(pair.keys.of("roark").path() / "trusted");
    here = "session.failed.not_trusted_there", there = "session.refused.certificate_unknown";
    words = "the peer does not trust this lab's certificate";
  }
  SUBCASE("revoked by who connects") {
    pair.keys.of("roark").revoke("shark");
    here = "session.failed.revoked_there", there = "session.refused.certificate_revoked";
    words = "the peer has revoked this lab's certificate";
  }
  pair.start();
  REQUIRE(pair.comes_to([&] { return pair.shark->count(here) > 1 && pair.roark->count(there) > 1; }));
  CHECK(pair.shark->noticed(words));
  CHECK_FALSE(pair.shark->up());
  CHECK_FALSE(pair.roark->up());
  CHECK(pair.roark->count("session.opened") == 0);
}

TEST_CASE("another lab at the peer's address is not talked to") {
  // Although its certificate is trusted: it is lynx's, and roark was meant to be there.
  TestKeys keys;
  keys.join("shark", "lynx");
  keys.join("shark", "roark");
  boost::asio::io_context io;
  TlsEnd lynx(io, "lynx", keys.tls("lynx"), "tls://127.0.0.1:0");
  lynx.expect("shark");
  TlsEnd shark(io, "shark", keys.tls("shark"));
  shark.connect("roark", lynx);
  REQUIRE(run_until(
      io, [&] { return shark.count("session.refused.certificate_of_other_lab") > 1; }, std::chrono::seconds(300)));
  CHECK(shark.link->stats().why.find("the other end has the certificate of lab lynx, not of lab roark") !=
        std::string::npos);
  CHECK_FALSE(lynx.up());
}

TEST_CASE("a lab cannot call itself by another's name") {
  // Roark's certificate and lynx's name in the hello: refused although both are expected.
  TestKeys keys;
  keys.join("shark", "lynx");
  keys.join("shark", "roark");
  boost::asio::io_context io;
  TlsEnd shark(io, "shark", keys.tls("shark"), "tls://127.0.0.1:0");
  shark.expect("lynx");
  TlsEnd liar(io, "lynx", keys.tls("roark"));
  liar.connect("shark", shark);
  REQUIRE(run_until(
      io, [&] { return shark.count("session.refused.lab_name") > 1; }, std::chrono::seconds(300)));
  CHECK(shark.noticed("a connection with the certificate of lab roark calls itself lab lynx"));
  CHECK(run_until(
      io, [&] { return liar.count("session.closed.bye") > 0; }, std::chrono::seconds(300)));
  CHECK_FALSE(shark.up());
}

TEST_CASE("no date locks a trusted lab out") {
  // Certificates that ended years ago, or begin in years, as seen by a clock that is wrong; what ends soon is said.
  TlsPair pair;
  const auto now = std::chrono::system_clock::now();
  pair.keys.date("shark", now + std::chrono::days(3000));
  SUBCASE("ended") {
    pair.keys.date("roark", now - std::chrono::days(9000));
    pair.keys.of("shark").trust(pair.keys.of("roark").certificate_file("roark"), false);
    pair.start();
    REQUIRE(pair.both_up());
    CHECK(pair.shark->link->stats().counters.all().contains("certificate.days_left"));
    CHECK(pair.shark->count("certificate.days_left") == 0);
  }
  SUBCASE("ends soon") {
    pair.keys.date("roark", now - certificate_life + std::chrono::days(20));
    pair.keys.of("shark").trust(pair.keys.of("roark").certificate_file("roark"), false);
    pair.start();
    REQUIRE(pair.both_up());
    CHECK(pair.shark->count("certificate.days_left") == 19);
    // Renewed with the same key: nothing is to be done at shark, and nothing more is said.
    pair.keys.of("roark").renew("roark", false);
    TlsEnd again(pair.io, "roark", pair.keys.tls("roark"));
    again.connect("shark", *pair.shark);
    REQUIRE(pair.comes_to([&] { return !pair.shark->link->stats().counters.all().contains("certificate.days_left"); }));
  }
  CHECK_FALSE(pair.roark->link->stats().counters.all().contains("certificate.days_left"));
}

TEST_CASE("trust and revocation act on a gateway that runs") {
  // A live link ends within a heartbeat, its lab is refused from then on, and let in again when it is trusted again.
  TlsPair pair;
  pair.start();
  REQUIRE(pair.both_up());
  pair.keys.of("shark").revoke("roark");
  REQUIRE(pair.comes_to([&] { return pair.shark->count("session.closed.certificate_revoked") == 1; }));
  REQUIRE(pair.comes_to([&] { return pair.shark->count("session.refused.certificate_revoked") > 0; }));
  CHECK_FALSE(pair.shark->up());
  pair.keys.trust("shark", "roark", true);
  REQUIRE(pair.both_up());
  // Its key is replaced: the old one is out, the new one in, without a restart of shark.
  pair.keys.of("roark").renew("roark", true);
  pair.keys.trust("shark", "roark", true);
  REQUIRE(pair.comes_to([&] { return pair.shark->count("session.closed.certificate_untrusted") == 1; }));
  CHECK(pair.both_up());
}

TEST_CASE("trust that ends while hands are shaken opens nothing") {
  // At each moment of the handshake: what began with a trusted key is refused when the key is not trusted at its end.
  int during = 0;
  for (int step = 1; step < 60; ++step) {
    CAPTURE(step);
    TlsPair pair;
    const auto keys = pair.keys.tls("shark");
    pair.shark = std::make_unique<TlsEnd>(pair.io, "shark", keys, "tls://127.0.0.1:0");
    pair.shark->expect("roark");
    pair.roark = std::make_unique<TlsEnd>(pair.io, "roark", pair.keys.tls("roark"));
    pair.roark->connect("shark", *pair.shark);
    for (int i = 0; i < step; ++i) pair.io.run_one_for(std::chrono::seconds(10));
    const bool opened = pair.shark->count("session.opened") > 0;
    std::filesystem::remove_all(pair.keys.of("shark").path() / "trusted");
    keys->refresh();
    REQUIRE(pair.comes_to([&] {
      return pair.shark->count("session.refused.certificate_unknown") > 0 ||
             pair.shark->count("session.closed.certificate_untrusted") > 0;
    }));
    if (opened) break;
    CHECK(pair.shark->count("session.opened") == 0);
    ++during;
  }
  CHECK(during > 3);
}

TEST_CASE("plain TCP and TLS do not mix, and both ends say so") {
  TlsPair pair;
  SUBCASE("plain to a TLS port") {
    TlsEnd shark(pair.io, "shark", pair.keys.tls("shark"), "tls://127.0.0.1:0");
    shark.expect("roark");
    TlsEnd roark(pair.io, "roark", nullptr);
    roark.start(roark.node->link("shark", fmt::format("127.0.0.1:{}", shark.node->listening().port())));
    REQUIRE(pair.comes_to(
        [&] { return shark.count("session.refused.plain_tcp") > 1 && roark.count("session.closed.speaks_tls") > 0; }));
    for (const char* garbage : {"GET / HTTP/1.1\r\nHost: shark\r\n\r\n", "SSH-2.0-OpenSSH_9.2p1\r\n"}) {
      RawPeer stranger(pair.io, shark.node->listening().port());
      stranger.listen();
      stranger.say(std::string_view(garbage));
      REQUIRE(pair.comes_to([&] { return stranger.closed; }));
    }
  }
  SUBCASE("TLS to a plain port") {
    TlsEnd shark(pair.io, "shark", nullptr, "127.0.0.1:0");
    shark.expect("roark");
    TlsEnd roark(pair.io, "roark", pair.keys.tls("roark"));
    roark.connect("shark", shark);
    REQUIRE(pair.comes_to(
        [&] { return shark.count("session.closed.speaks_tls") > 1 && roark.count("session.refused.plain_tcp") > 1; }));
  }
}

TEST_CASE("a thousand idle connections do not keep the peer out") {
  // Those of one address have 8 of the 16 places, and 5 s for the handshake; the peer gets in while they come.
  TlsPair pair;
  TlsEnd shark(pair.io, "shark", pair.keys.tls("shark"), "tls://127.0.0.1:0");
  shark.expect("roark");
  const tcp::endpoint there(boost::asio::ip::address_v4::loopback(), shark.node->listening().port());
  std::vector<tcp::socket> idle;
  const auto flood = [&](int n) {
    for (int i = 0; i < n; ++i) {
      tcp::socket& socket = idle.emplace_back(pair.io, tcp::v4());
      socket.bind({boost::asio::ip::make_address("127.0.0.2"), 0});
      socket.connect(there);
      pair.io.restart();
      pair.io.poll();
    }
  };
  flood(300);
  TlsEnd roark(pair.io, "roark", pair.keys.tls("roark"));
  roark.connect("shark", shark);
  REQUIRE(run_until(
      pair.io,
      [&] {
        if (idle.size() < 600) flood(5);
        return shark.up() && roark.up();
      },
      std::chrono::seconds(300)));
  flood(1000 - static_cast<int>(idle.size()));
  REQUIRE(pair.comes_to([&] {
    return shark.count("session.closed.too_many_of_address") + shark.count("session.failed.slow_handshake") == 1000;
  }));
  CHECK(shark.count("session.failed.slow_handshake") >= 8);
  CHECK(shark.count("session.closed.too_many_pending") == 0);
  CHECK(shark.up());
  CHECK(roark.count("session.opened") == 1);
}

}  // namespace
}  // namespace arkmesh::gateway
