// Packets between labs that meet at a server: what they hold comes back, and nothing that is not one is taken for one.
// Who can read and verify them. And where the servers are.
#include <doctest/doctest.h>
#include <openssl/evp.h>
#include <openssl/pem.h>

#include <algorithm>
#include <string>
#include <vector>

#include "gateway/federation/nats_address.hpp"
#include "gateway/federation/packet.hpp"
#include "gateway/federation/seals.hpp"
#include "hal/config/config.hpp"
#include "hal/random.hpp"

namespace arkmesh::gateway {
namespace {

std::vector<std::byte> spelled(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// A body of chance, with memory of its own for the chunks.
struct RandomBody {
  std::vector<std::vector<std::byte>> memory;
  PacketBody body;

  explicit RandomBody(hal::RandomStream& chance) {
    for (std::uint64_t n = chance.below(5); n > 0; --n)
      body.greetings.push_back(
          {"lab-" + std::to_string(chance.below(100)), chance.next() | 1, chance.next(), chance.below(2) == 1});
    memory.resize(chance.below(6));
    for (auto& each : memory) {
      each.resize(chance.below(200));
      for (std::byte& byte : each) byte = static_cast<std::byte>(chance.below(256));
      body.chunks.emplace_back(each);
    }
    for (std::uint64_t n = chance.below(5); n > 0; --n) {
      Piece& piece = body.pieces.emplace_back();
      piece.yours = chance.next() | 1;
      piece.mine = chance.next() | 1;
      piece.offset = chance.next();
      piece.acknowledged = chance.next();
      piece.asks_again = chance.below(2) == 1;
      for (std::uint64_t k = memory.empty() ? 0 : chance.below(10); k > 0; --k)
        piece.chunks.push_back(static_cast<std::uint16_t>(chance.below(memory.size())));
    }
    for (std::uint64_t n = chance.below(5); n > 0; --n) body.endings.push_back({chance.next() | 1, chance.next() | 1});
  }
};

std::vector<std::byte> packet(const PacketHead& head, std::span<const std::byte> body) {
  std::vector<std::byte> out = encode_head(head);
  out.insert(out.end(), body.begin(), body.end());
  if (head.kind != PacketKind::sealed) out.resize(out.size() + signature_bytes, std::byte{7});
  return out;
}

TEST_CASE("packets hold what was put into them") {
  // Heads and bodies of chance: read, and written again, they are the same.
  hal::RandomStream chance(1, "packet test");
  for (int i = 0; i < 300; ++i) {
    const RandomBody random(chance);
    const auto encoded = encode_body(random.body);
    const PacketHead head{static_cast<PacketKind>(1 + chance.below(6)), "shark", chance.next() | 1, chance.next()};
    const auto whole = packet(head, encoded);
    const auto view = read_packet(whole);
    REQUIRE(view);
    CHECK(view->head.kind == head.kind);
    CHECK(view->head.from == "shark");
    CHECK(view->head.boot_id == head.boot_id);
    CHECK(view->head.number == head.number);
    CHECK(std::ranges::equal(view->body, encoded));
    CHECK(std::ranges::equal(view->head_bytes, encode_head(head)));
    CHECK(view->signed_bytes.size() + view->signature.size() == (head.kind == PacketKind::sealed ? 0 : whole.size()));
    const auto body = read_body(view->body);
    REQUIRE(body);
    CHECK(encode_body(*body) == encoded);
    CHECK(body->greetings.size() == random.body.greetings.size());
    CHECK(body->pieces.size() == random.body.pieces.size());
    CHECK(body->endings.size() == random.body.endings.size());
    REQUIRE(body->chunks.size() == random.body.chunks.size());
    for (std::size_t k = 0; k < body->chunks.size(); ++k)
      CHECK(std::ranges::equal(body->chunks[k], random.body.chunks[k]));
  }
}

TEST_CASE("keys hold what was put into them") {
  // Each reader's beginning of a pin and its sealed key come back; a list that goes on behind its end is none.
  const auto one = spelled("sealed for one"), other = spelled("for the other");
  const std::vector<SealedKey> keys{{{std::byte{1}, std::byte{2}}, one}, {{std::byte{3}}, other}, {{}, {}}};
  auto encoded = encode_keys(keys);
  const auto read = read_keys(encoded);
  REQUIRE(read);
  REQUIRE(read->size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK((*read)[i].reader == keys[i].reader);
    CHECK(std::ranges::equal((*read)[i].sealed, keys[i].sealed));
  }
  for (std::size_t size = 0; size < encoded.size(); ++size) CHECK_FALSE(read_keys(std::span(encoded).first(size)));
  encoded.emplace_back();
  CHECK_FALSE(read_keys(encoded));
}

TEST_CASE("what is watched comes back") {
  // Channels and bytes; not with a channel that nobody can export, nor cut off.
  const auto one = spelled("the world"), none = spelled("");
  const auto encoded = encode_watched(std::vector<Watched>{{"world", one}, {"status", none}});
  const auto read = read_watched(encoded);
  REQUIRE(read);
  REQUIRE(read->size() == 2);
  CHECK((*read)[0].channel == "world");
  CHECK(std::ranges::equal((*read)[0].bytes, one));
  CHECK((*read)[1].channel == "status");
  for (std::size_t size = 0; size < encoded.size(); ++size) CHECK_FALSE(read_watched(std::span(encoded).first(size)));
  for (const char* wrong : {"", "roark/world", "a b"})
    CHECK_FALSE(read_watched(encode_watched(std::vector<Watched>{{wrong, one}})));
}

TEST_CASE("a damaged packet is refused or another one") {
  // No beginning of a body is a body; with any bit flipped, what is read is well-formed.
  hal::RandomStream chance(2, "packet test");
  for (int i = 0; i < 20; ++i) {
    const RandomBody random(chance);
    const auto encoded = encode_body(random.body);
    for (std::size_t size = 0; size < encoded.size(); ++size) {
      const std::vector<std::byte> cut(encoded.begin(), encoded.begin() + static_cast<std::ptrdiff_t>(size));
      CHECK_FALSE(read_body(cut));
    }
    const auto whole = packet({PacketKind::signed_open, "shark", 5, 6}, encoded);
    for (std::size_t at = 0; at < whole.size(); ++at)
      for (const int bit : {0, 3, 7}) {
        auto damaged = whole;
        damaged[at] ^= static_cast<std::byte>(1 << bit);
        const auto view = read_packet(damaged);
        if (!view) continue;
        CHECK(view->head_bytes.size() + view->body.size() + view->signature.size() == damaged.size());
        const auto body = read_body(view->body);
        if (!body) continue;
        for (const Piece& piece : body->pieces) {
          CHECK(piece.mine != 0);
          for (const std::uint16_t number : piece.chunks) CHECK(number < body->chunks.size());
        }
      }
  }
}

TEST_CASE("what is no packet of ours is refused") {
  // Another magic or kind, no lab's name, no boot id, no room for a signature; a stream without number, a chunk that is
  // not there, more of anything than may be.
  const PacketHead head{PacketKind::signed_open, "shark", 5, 6};
  CHECK(read_packet(packet(head, {})));
  CHECK_FALSE(read_packet({}));
  CHECK_FALSE(read_packet(encode_head(head)));
  for (const auto& wrong :
       {PacketHead{static_cast<PacketKind>(0), "shark", 5, 6}, PacketHead{static_cast<PacketKind>(7), "shark", 5, 6},
        PacketHead{PacketKind::signed_open, "", 5, 6}, PacketHead{PacketKind::signed_open, "a.b", 5, 6},
        PacketHead{PacketKind::signed_open, "ALL", 5, 6}, PacketHead{PacketKind::signed_open, "sha\nrk", 5, 6},
        PacketHead{PacketKind::signed_open, "shark", 0, 6}})
    CHECK_FALSE(read_packet(packet(wrong, {})));
  auto other = packet(head, {});
  other[4] = std::byte{2};
  CHECK_FALSE(read_packet(other));

  CHECK(read_body(encode_body({})));
  CHECK_FALSE(read_body(encode_body({.greetings = {{"roark", 0, 1}}})));
  CHECK_FALSE(read_body(encode_body({.greetings = {{"ALL", 1, 1}}})));
  CHECK_FALSE(read_body(encode_body({.pieces = {{.yours = 0, .mine = 1}}})));
  CHECK_FALSE(read_body(encode_body({.pieces = {{.yours = 1, .mine = 0}}})));
  CHECK_FALSE(read_body(encode_body({.pieces = {{.yours = 1, .mine = 1, .chunks = {0}}}})));
  CHECK_FALSE(read_body(encode_body({.endings = {{0, 1}}})));
  CHECK_FALSE(read_body(encode_body({.endings = {{1, 0}}})));
  auto longer = encode_body({});
  longer.emplace_back();
  CHECK_FALSE(read_body(longer));

  PacketBody many;
  many.endings.resize(max_packet_entries, {1, 1});
  CHECK(read_body(encode_body(many)));
  many.endings.push_back({1, 1});
  CHECK_FALSE(read_body(encode_body(many)));
}

TEST_CASE("an experiment's name is one token of a subject") {
  // Whatever it is called; no two names make the same.
  CHECK(subject_root("dhtf") == "arkmesh.dhtf");
  CHECK(subject_root("") == "arkmesh.-");
  const std::vector<std::string> names{"",    "-a", "%", "%2D", "a.b", "a%2Eb",    "a b", "*",   ">",
                                       "a.*", "\t", "a", "A",   "\n",  "\xc3\xa9", "a/b", "$SYS"};
  std::vector<std::string> roots;
  for (const std::string& name : names) {
    CAPTURE(name);
    roots.push_back(subject_root(name));
    const std::string token = roots.back().substr(8);
    CHECK_FALSE(token.empty());
    CHECK(token.find_first_of(".*> \t\r\n") == std::string::npos);
  }
  std::ranges::sort(roots);
  CHECK(std::ranges::adjacent_find(roots) == roots.end());
}

// A lab with its key.
struct Lab {
  std::string name, key;
  Certificate certificate;

  explicit Lab(const std::string& of, std::string key_pem = make_key())
      : name(of), key(std::move(key_pem)), certificate(read_certificate(make_certificate(key, of))) {}
  Seals trusting(const std::vector<Certificate>& others) const { return {key, certificate.pin, others}; }
};

std::string p256_key() {
  const KeyPointer key(EVP_EC_gen("P-256"));
  BIO* const memory = BIO_new(BIO_s_mem());
  PEM_write_bio_PrivateKey(memory, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
  char* text = nullptr;
  const long size = BIO_get_mem_data(memory, &text);
  std::string pem(text, static_cast<std::size_t>(size));
  BIO_free(memory);
  return pem;
}

TEST_CASE("a lab's signature is verified with its certificate's key") {
  // The same bytes and the same lab only.
  const Lab shark("shark"), roark("roark"), lynx("lynx");
  const Seals ours = shark.trusting({roark.certificate});
  const Seals theirs = roark.trusting({shark.certificate, lynx.certificate});
  REQUIRE(ours.can_sign());
  const auto said = spelled("what shark says");
  const auto signature = ours.sign(said);
  REQUIRE(theirs.of("shark"));
  CHECK(theirs.of("shark")->has_signed(said, signature));
  CHECK_FALSE(theirs.of("lynx")->has_signed(said, signature));
  CHECK_FALSE(theirs.of("shark")->has_signed(spelled("what shark said"), signature));
  CHECK_FALSE(theirs.of("shark")->has_signed(said, std::span(signature).first(63)));
  CHECK_FALSE(theirs.of("shark")->has_signed(said, {}));
  for (std::size_t at = 0; at < signature.size(); ++at) {
    auto damaged = signature;
    damaged[at] ^= std::byte{1};
    CHECK_FALSE(theirs.of("shark")->has_signed(said, damaged));
  }
}

TEST_CASE("what is sealed for a lab opens for that lab only") {
  // Both ends have the same secret, which no third lab has; what stands beside it has to be the same; any change is
  // found.
  const Lab shark("shark"), roark("roark"), lynx("lynx");
  const std::vector<Certificate> all{shark.certificate, roark.certificate, lynx.certificate};
  const Seals of_shark = shark.trusting(all), of_roark = roark.trusting(all), of_lynx = lynx.trusting(all);
  const auto said = spelled("for roark alone"), beside = spelled("dhtf, roark, packet 7");
  const auto sealed = seal(of_shark.of("roark")->shared, said, beside);
  CHECK(sealed.size() == said.size() + seal_bytes);
  CHECK(std::search(sealed.begin(), sealed.end(), said.begin(), said.end()) == sealed.end());
  CHECK(unseal(of_roark.of("shark")->shared, sealed, beside) == said);
  for (const Seals* seals : {&of_lynx, &of_roark, &of_shark})
    for (const auto& each : seals->others()) {
      const std::string& lab = each.first;
      const bool is_theirs = (seals == &of_roark && lab == "shark") || (seals == &of_shark && lab == "roark");
      CAPTURE(lab);
      CHECK(unseal(each.second.shared, sealed, beside).has_value() == is_theirs);
    }
  const SecretKey& key = of_roark.of("shark")->shared;
  for (const char* wrong : {"cre, roark, packet 7", "dhtf, lynx, packet 7", "dhtf, roark, packet 8", ""})
    CHECK_FALSE(unseal(key, sealed, spelled(wrong)));
  for (std::size_t at = 0; at < sealed.size(); ++at) {
    auto damaged = sealed;
    damaged[at] ^= std::byte{0x80};
    CHECK_FALSE(unseal(key, damaged, beside));
    CHECK_FALSE(unseal(key, std::span(sealed).first(at), beside));
  }
  CHECK(seal(of_shark.of("roark")->shared, said, beside) != sealed);  // each time with another nonce
  CHECK(unseal(key, seal(key, {}, {}), {})->empty());
}

TEST_CASE("keys of another kind neither sign nor are trusted") {
  // A lab with a P-256 key cannot take part, and is nobody to the others; nor is one that is not trusted.
  const Lab shark("shark"), roark("roark"), old("old", p256_key());
  CHECK_FALSE(old.trusting({shark.certificate}).can_sign());
  CHECK_FALSE(old.trusting({shark.certificate}).of("shark"));
  const Seals seals = shark.trusting({old.certificate, roark.certificate});
  CHECK_FALSE(seals.of("old"));
  CHECK(seals.of("roark"));
  CHECK_FALSE(seals.of("lynx"));
  CHECK_FALSE(Seals().can_sign());
  CHECK_FALSE(Seals("no key at all", {}, {roark.certificate}).can_sign());
}

TEST_CASE("lists of NATS servers") {
  // Hosts with and without port, user and scheme, in their order; anything else is refused in words.
  const NatsServers servers = read_servers(
      "nats.example.org, shark:pa:ss@10.1.2.3:4333 ,[2001:db8::7],tls+nats://a@b:c@[::1]:1,localhost:4222", true);
  CHECK(servers.tls);
  REQUIRE(servers.all.size() == 5);
  const std::vector<std::string> hosts{"nats.example.org:4222", "10.1.2.3:4333", "[2001:db8::7]:4222", "[::1]:1",
                                       "localhost:4222"};
  for (std::size_t i = 0; i < hosts.size(); ++i) CHECK(to_text(servers.all[i].host) == hosts[i]);
  CHECK(servers.all[0].user.empty());
  CHECK(servers.all[1].user == "shark");
  CHECK(servers.all[1].password == "pa:ss");
  CHECK(servers.all[3].user == "a@b");
  CHECK(servers.all[3].password == "c");
  for (const char* wrong : {"",        ",",    "a.example.org,", ",a.example.org", "a,,b",    "nats.example.org:0",
                            "a:65536", "a:b",  "user@a",         ":secret@a",      "user:@a", "@a",
                            "a b",     "[::1", "http://a",       "nats://",        "a/b",     "a:1:2",
                            "a\n",     "::1"}) {
    CAPTURE(wrong);
    CHECK(why_no_servers(wrong).starts_with("must be [USER:PASSWORD@]HOST[:PORT], or several"));
    CHECK(why_no_open_servers(wrong).starts_with("must be [USER:PASSWORD@]HOST[:PORT], or several"));
    CHECK_THROWS_AS((void)read_servers(wrong, false), hal::ConfigError);
  }
}

TEST_CASE("a password goes over encrypted connections only") {
  // Or to a server on this machine, which nobody else can listen to.
  CHECK(why_no_open_servers("a.example.org,user:secret@127.0.0.1,user:secret@[::1]:4333").empty());
  CHECK(why_no_servers("user:secret@a.example.org").empty());
  CHECK(why_no_open_servers("127.0.0.1,user:secret@a.example.org") ==
        "would send a password to a.example.org:4222 unencrypted; use tls+nats://");
  CHECK(is_nats("nats://a"));
  CHECK(is_nats("tls+nats://a"));
  CHECK_FALSE(is_nats("tls://a"));
  CHECK_FALSE(is_nats("a"));
}

}  // namespace
}  // namespace arkmesh::gateway
