// Labs that meet at a server which does what it should not: loses, repeats, reorders, keeps, forges, stops; and that
// have a member who does. Nobody hears what was not said, and what was said is heard.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <string>
#include <vector>

#include "gateway/frame/frame.hpp"
#include "hal/random.hpp"
#include "tests/support/network/meeting.hpp"
#include "tests/support/network/nats_server.hpp"

namespace arkmesh::gateway {
namespace {

using namespace tests;
using namespace std::chrono_literals;
using Message = HostileNats::Message;

// Says so many things, a few in each turn, and what it has said.
std::vector<std::string> say(Meeting& meeting, MeetingLab& lab, int count, std::size_t bytes = 60) {
  std::vector<std::string> said;
  for (int i = 0; i < count; ++i) {
    said.push_back(fmt::format("{} {} {}", lab.name, i, std::string((static_cast<std::size_t>(i) * 37) % bytes, 'x')));
    lab.say(said.back());
    if (i % 5 == 0) meeting.pass(1ms);
  }
  return said;
}

struct TwoLabs : Meeting {
  MeetingLab &shark, &roark;
  explicit TwoLabs(std::size_t max_payload = 1 << 20, const Habits& habits = {})
      : Meeting(max_payload), shark(start("shark", {"roark"}, habits)), roark(start("roark", {"shark"}, habits)) {}
  void meet() {
    REQUIRE(until([&] { return all_up(); }));
  }
  // So much each way arrives, each once and in order, and the books balance.
  void exchange(int count) {
    meet();
    const auto by_shark = say(*this, shark, count), by_roark = say(*this, roark, count);
    CHECK(heard("roark", "shark", by_shark));
    CHECK(heard("shark", "roark", by_roark));
    check_settled();
  }
  // Something each way arrives, once.
  void check_passage(const std::string& text = "through") {
    meet();
    const auto by_shark = shark.heard["roark"].size(), by_roark = roark.heard["shark"].size();
    shark.say(text);
    roark.say(text);
    CHECK(until([&] { return shark.heard["roark"].size() > by_shark && roark.heard["shark"].size() > by_roark; }));
    CHECK(shark.heard["roark"].size() == by_shark + 1);
    CHECK(roark.heard["shark"].size() == by_roark + 1);
  }
};

TEST_CASE("a server that loses, repeats and reorders costs nothing") {
  // Every ordered message arrives once and in order, both ways, whether all can read it or none; the books balance.
  struct Row {
    const char* name;
    double lost, repeated, held;
    bool encrypt;
  };
  for (const Row& row : {Row{"one in ten is lost", 0.1, 0, 0, false}, Row{"and encrypted", 0.1, 0, 0, true},
                         Row{"repeated", 0, 0.5, 0, false}, Row{"out of order", 0, 0, 0.3, false},
                         Row{"all of it", 0.1, 0.2, 0.2, true}}) {
    CAPTURE(row.name);
    TwoLabs labs(1 << 20, {.encrypt = row.encrypt});
    hal::RandomStream chance(1, row.name);
    std::deque<Message> held;
    labs.server.instead = [&](const Message& message) {
      std::vector<Message> out;
      if (chance.uniform() >= row.lost) out.push_back(message);
      if (chance.uniform() < row.repeated) out.push_back(message);
      if (!out.empty() && chance.uniform() < row.held) {
        held.push_back(out.back());
        out.pop_back();
      }
      if (!held.empty() && chance.uniform() < 0.4) {
        out.push_back(held.front());
        held.pop_front();
      }
      return out;
    };
    labs.exchange(300);
    // What comes twice is not looked at; what comes late is said again meanwhile, in a packet of its own.
    const std::string counter = row.lost > 0       ? "federation.pieces.sent_again"
                                : row.repeated > 0 ? "federation.refused.repeated"
                                                   : "federation.pieces.repeated";
    const auto counted = [&](auto& lab, const char* peer) {
      return lab.count(counter) + lab.count(fmt::format("{}.{}", counter, peer));
    };
    CHECK(counted(labs.shark, "roark") + counted(labs.roark, "shark") > 0);
  }
}

TEST_CASE("what a server changes is not heard") {
  // Each message comes with damaged ones before it: other bytes, cut off, of another sender, on another subject. None
  // of them is heard, they are counted, and the link stays up.
  for (const bool encrypt : {false, true}) {
    TwoLabs labs(1 << 20, {.encrypt = encrypt});
    hal::RandomStream chance(2, "changes");
    labs.server.instead = [&](const Message& message) {
      std::vector<Message> out(4, message);
      out[0].bytes[chance.below(message.bytes.size())] ^= static_cast<char>(1 << chance.below(8));
      out[1].bytes.resize(chance.below(message.bytes.size()));
      const bool by_shark = message.subject.find(".shark.") != std::string::npos;
      for (const int i : {2, 3}) {
        // The other lab's name has as many letters.
        auto& text = i == 2 ? out[2].bytes : out[3].subject;
        text.replace(text.find(by_shark ? "shark" : "roark"), 5, by_shark ? "roark" : "shark");
      }
      out.push_back(message);
      return out;
    };
    labs.exchange(100);
    for (const MeetingLab* lab : {&labs.shark, &labs.roark}) {
      const std::string other = lab == &labs.shark ? "roark" : "shark";
      CHECK(lab->count("federation.refused.seal." + other) > 0);
      CHECK(lab->count("federation.refused.malformed") > 0);
      CHECK(lab->count("federation.refused.subject") > 0);
      CHECK(lab->count(other, "session.opened") == 1);
    }
    CHECK(labs.shark.count("federation.refused.signature.roark") +
              labs.shark.count("federation.refused.too_many_forged.roark") >
          0);
  }
}

TEST_CASE("what a server has kept from before is not heard") {
  // All packets of earlier sessions, before and after one lab is started again, each several times: no message comes
  // twice, and the links go on.
  TwoLabs labs;
  std::vector<Message> past;
  labs.server.published = [&](const Message& message) { past.push_back(message); };
  labs.meet();
  const auto first = say(labs, labs.shark, 50);
  CHECK(labs.heard("roark", "shark", first));
  labs.server.cut();
  CHECK(labs.until(
      [&] { return labs.shark.count("server.connected") == 2 && labs.roark.count("server.connected") == 2; }));
  for (const Message& each : std::vector(past)) labs.server.forward(each);
  labs.check_passage("after the cut");
  labs.check_settled();  // what was not acknowledged would be said to the next gateway of roark
  labs.start("roark", {"shark"});
  CHECK(labs.until([&] { return labs.shark.count("roark", "session.opened") >= 2 && labs.all_up(); }));
  const auto opened = labs.shark.count("roark", "session.opened");
  const auto heard = labs.shark.heard["roark"].size();
  for (int i = 0; i < 3; ++i) {
    for (const Message& each : std::vector(past)) labs.server.forward(each);
    labs.pass(50ms);
  }
  CHECK(labs.roark.heard["shark"].empty());
  CHECK(labs.shark.heard["roark"].size() == heard);
  labs.check_passage("after all of it");
  CHECK(labs.shark.count("roark", "session.opened") == opened);
  labs.server.published = {};
}

TEST_CASE("a server that ends connections does not end sessions") {
  // Also in the midst of a message: labs connect again before they would miss each other, and nothing is lost.
  TwoLabs labs;
  labs.meet();
  for (std::uint64_t i = 1; i <= 4; ++i) {
    const auto before = labs.roark.heard["shark"].size();
    const auto said = say(labs, labs.shark, 20);
    labs.server.cut(i % 2 == 0);
    labs.shark.say("in the gap");
    REQUIRE(labs.until([&] {
      return labs.shark.count("server.connected") == i + 1 && labs.roark.count("server.connected") == i + 1;
    }));
    CHECK(labs.until([&] { return labs.roark.heard["shark"].size() == before + 21; }));
    CHECK(labs.roark.heard["shark"].back() == "in the gap");
  }
  CHECK(labs.shark.count("server.closed.lost") == 4);
  CHECK(labs.shark.count("roark", "session.opened") == 1);
  labs.check_settled();
}

TEST_CASE("a server whose message never ends is left") {
  // After a megabyte of it, and tried again later each time.
  TwoLabs labs;
  labs.meet();
  for (std::uint64_t i = 1; i <= 3; ++i) {
    const auto before = labs.roark.heard["shark"].size();
    labs.server.begin_endless(2 << 20);
    REQUIRE(labs.until([&] {
      return labs.shark.count("server.closed.endless") == i && labs.shark.count("server.connected") == i + 1;
    }));
    REQUIRE(labs.until([&] { return labs.roark.count("server.connected") == i + 1; }));
    labs.shark.say("behind it");
    CHECK(labs.until([&] { return labs.roark.heard["shark"].size() == before + 1; }));
  }
  labs.check_settled();
}

TEST_CASE("a server that takes little at once is served in small packets") {
  // Thousands of messages of a few bytes that wait together, and one of 1 MiB: no packet is longer than it takes.
  TwoLabs labs(32 << 10);
  labs.meet();
  // Until the labs know that much may be under way.
  std::vector<std::string> said = say(labs, labs.shark, 100, 100'000);
  CHECK(labs.heard("roark", "shark", said));
  bool is_deaf = true;
  labs.server.instead = [&](const Message& message) {
    return is_deaf ? std::vector<Message>{} : std::vector<Message>{message};
  };
  for (int i = 0; i < 5000; ++i) {
    said.push_back(std::to_string(i % 10));
    labs.shark.say(said.back());
  }
  labs.pass(1000ms);
  is_deaf = false;
  said.emplace_back(1 << 20, 'x');
  labs.shark.say(said.back());
  CHECK(labs.heard("roark", "shark", said));
  CHECK(labs.server.too_long() == 0);
  CHECK(labs.shark.count("roark", "session.opened") == 1);
  labs.check_settled();
}

TEST_CASE("a server that takes too little is not used") {
  // The link says why, and what to change.
  TwoLabs labs((32 << 10) - 1);
  CHECK(labs.until([&] { return labs.shark.count("server.refused.payload_limit") > 0; }));
  CHECK(labs.until([&] {
    return labs.shark.links["roark"]->stats().why.ends_with(
        "it accepts messages of 32767 bytes at most; set its max_payload to 32768 or more");
  }));
}

TEST_CASE("one publication reaches all peers") {
  // 100 messages for one peer or for five are as many publications.
  for (const bool encrypt : {false, true})
    for (const int peers : {1, 5}) {
      CAPTURE(peers);
      Meeting meeting;
      std::vector<std::string> names;
      for (int i = 0; i < peers; ++i) names.push_back("peer-" + std::to_string(i));
      MeetingLab& shark = meeting.start("shark", names, {.encrypt = encrypt});
      for (const std::string& each : names) meeting.start(each, {"shark"}, {.encrypt = encrypt});
      REQUIRE(meeting.until([&] { return meeting.all_up(); }));
      const auto published = [&] {
        std::uint64_t n = 0;
        for (const auto& [subject, count] : meeting.server.publications())
          if (subject == "arkmesh.dhtf.shark.ALL") n = count;
        return n;
      };
      meeting.pass(300ms);
      const std::uint64_t before = published();
      const auto began = std::chrono::steady_clock::now();
      std::vector<std::string> said;
      for (std::size_t i = 0; i < 100; ++i) {
        said.push_back("message " + std::to_string(i));
        shark.say(said.back());
        REQUIRE(meeting.until([&] {
          return std::ranges::all_of(names,
                                     [&](const auto& each) { return meeting.labs[each].heard["shark"].size() > i; });
        }));
      }
      for (const std::string& each : names) CHECK(meeting.labs[each].heard["shark"] == said);
      // What is late on a busy machine is said again to the one that misses it.
      const std::uint64_t spent = published() - before;
      const auto keys = static_cast<std::uint64_t>(encrypt) * (2 + (std::chrono::steady_clock::now() - began) / 2s);
      CHECK(spent <= 100 + keys);
      CHECK(spent > 50);
    }
}

TEST_CASE("experiments on one server do not see each other") {
  // shark and lynx trust and expect each other, in different experiments: they do not meet, and do not hear each other
  // when the server forwards it to them.
  Meeting labs;
  MeetingLab& shark = labs.start("shark", {"roark", "lynx"});
  MeetingLab& roark = labs.start("roark", {"shark"});
  MeetingLab& lynx = labs.start("lynx", {"shark", "roark"}, {.experiment = "cre"});
  REQUIRE(labs.until([&] { return shark.up("roark") && roark.up("shark"); }));
  labs.server.instead = [&](const Message& message) {
    Message other = message;
    const bool is_dhtf = other.subject.starts_with("arkmesh.dhtf.");
    other.subject = std::string(is_dhtf ? "arkmesh.cre." : "arkmesh.dhtf.") + other.subject.substr(is_dhtf ? 13 : 12);
    return std::vector{message, other};
  };
  const auto said = say(labs, shark, 30);
  CHECK(labs.heard("roark", "shark", said));
  labs.pass(300ms);
  CHECK_FALSE(lynx.up("shark"));
  CHECK(lynx.heard["shark"].empty());
  CHECK(lynx.count("federation.refused.signature.shark") > 0);
  CHECK(shark.count("federation.refused.signature.lynx") > 0);
  CHECK(shark.up("roark"));
}

TEST_CASE("a stranger reads nothing and does not get in") {
  // A lab with the server's address whose key nobody trusts is not heard. With encrypt = true what is said stands in no
  // byte that the server forwards; without, it does.
  for (const bool encrypt : {false, true}) {
    CAPTURE(encrypt);
    TwoLabs labs(1 << 20, {.encrypt = encrypt});
    MeetingLab& stranger = labs.start("stranger", {"shark", "roark"}, {.encrypt = encrypt});
    REQUIRE(labs.until([&] { return labs.shark.up("roark") && labs.roark.up("shark"); }));
    std::vector<std::string> said;
    hal::RandomStream chance(3, "lost on the way");
    labs.server.instead = [&](const Message& message) {
      return chance.uniform() < 0.1 ? std::vector<Message>{} : std::vector<Message>{message};
    };
    for (int i = 0; i < 100; ++i) {
      said.push_back("the secret of " + std::to_string(i));
      labs.shark.say(said.back());
      if (i % 10 == 0) labs.pass(5ms);
    }
    CHECK(labs.heard("roark", "shark", said));
    CHECK(labs.server.has_forwarded("the secret of") == !encrypt);
    CHECK_FALSE(stranger.up("shark"));
    CHECK(stranger.heard["shark"].empty());
    CHECK(labs.shark.count("federation.refused.not_trusted") > 0);
  }
}

TEST_CASE("a lab that is revoked is out") {
  // Its link ends by itself, and the others' stay; what is encrypted from then on is not for the key that it knows.
  Meeting meeting;
  MeetingLab& shark = meeting.start("shark", {"roark", "lynx"}, {.encrypt = true});
  MeetingLab& roark = meeting.start("roark", {"shark"}, {.encrypt = true});
  meeting.start("lynx", {"shark"}, {.encrypt = true});
  REQUIRE(meeting.until([&] { return meeting.all_up(); }));
  const SecretKey pair_key = [&] { return meeting.keys.tls("lynx")->seals().of("shark")->shared; }();
  // What lynx can open: the group keys that were ever sealed for it.
  std::vector<SecretKey> known;
  std::size_t secret_packets = 0, opened = 0;
  meeting.server.published = [&](const Message& message) {
    const auto packet = read_packet(std::as_bytes(std::span(message.bytes)));
    if (!packet || packet->head.from != "shark") return;
    if (packet->head.kind == PacketKind::keys) {
      const auto sealed_keys = read_keys(packet->body);
      REQUIRE(sealed_keys);
      for (const SealedKey& each : *sealed_keys)
        if (const auto plain = unseal(pair_key, each.sealed, federation_context("dhtf", "lynx", packet->head_bytes))) {
          SecretKey key{};
          std::memcpy(key.data(), plain->data(), key.size());
          known.push_back(key);
        }
    }
    if (packet->head.kind != PacketKind::signed_secret) return;
    ++secret_packets;
    for (const SecretKey& key : known)
      if (unseal(key, packet->body, federation_context("dhtf", "ALL", packet->head_bytes))) {
        ++opened;
        break;
      }
  };
  REQUIRE(meeting.until([&] { return !known.empty(); }));
  std::vector<std::string> said = say(meeting, shark, 20);
  CHECK(meeting.heard("roark", "shark", said));
  CHECK(opened > 0);
  CHECK(opened == secret_packets);

  meeting.keys.of("shark").revoke("lynx");
  CHECK(meeting.until([&] { return !shark.up("lynx"); }));
  CHECK(shark.links["lynx"]->stats().why.find("was revoked") != std::string::npos);
  CHECK(shark.up("roark"));
  secret_packets = opened = 0;
  known.erase(known.begin(), known.end() - 1);
  const auto more = say(meeting, shark, 20);
  said.insert(said.end(), more.begin(), more.end());
  CHECK(meeting.heard("roark", "shark", said));
  CHECK(secret_packets > 0);
  CHECK(opened == 0);
  CHECK(roark.count("shark", "session.opened") == 1);
  meeting.server.published = {};
}

// shark and roark, and two that they trust: mole, who is malicious, and lynx, who does not come.
struct WithMole : Meeting {
  std::unique_ptr<RogueMember> mole;
  MeetingLab *shark = nullptr, *roark = nullptr;

  WithMole() {
    for (const char* lab : {"shark", "roark"}) keys.join(lab, "mole");
    shark = &start("shark", {"roark", "lynx", "mole"});
    roark = &start("roark", {"shark", "lynx", "mole"});
    mole = std::make_unique<RogueMember>(*this, "mole");
  }
  bool others_are_up() const { return shark->up("roark") && roark->up("shark"); }
  // Nothing is lost between the others in spite of what happens in each turn.
  void check_others(const std::function<void()>& in_each_turn) {
    REQUIRE(until([&] { return others_are_up(); }));
    std::vector<std::string> said;
    for (int i = 0; i < 40; ++i) {
      in_each_turn();
      said.push_back("meanwhile " + std::to_string(i));
      shark->say(said.back());
      pass(5ms);
    }
    CHECK(heard("roark", "shark", said));
    CHECK(shark->count("roark", "session.opened") == 1);
    CHECK(roark->count("shark", "session.opened") == 1);
    check_accounts(shark->links["roark"]->stats());
  }
};

TEST_CASE("a member who speaks in another's name is not heard") {
  // Signed and sealed with its own key as packets of others, thousands of them: counted under the others' names, said
  // a few times; shark and roark lose nothing, and meet again while it goes on.
  WithMole labs;
  const std::vector<std::byte> lie(100, std::byte{'!'});
  const auto flood = [&](int n) {
    for (int i = 0; i < n; ++i)
      for (const auto& [victim, other] : {std::pair("shark", "roark"), std::pair("roark", "shark"),
                                          std::pair("shark", "lynx"), std::pair("roark", "lynx")}) {
        const PacketBody body{.greetings = {{victim, 5, 6, true}}, .chunks = {lie}};
        labs.server.forward(labs.mole->signed_packet(body, other));
        labs.server.forward(labs.mole->sealed_packet(body, victim, other));
      }
  };
  const auto began = std::chrono::steady_clock::now();
  labs.check_others([&] { flood(10); });
  const auto refused = [&](const char* what) { return labs.shark->count(std::string("federation.refused.") + what); };
  CHECK(labs.until([&] { return refused("seal.roark") == 400 && refused("seal.lynx") == 400; }));
  CHECK(labs.until([&] { return refused("signature.roark") + refused("too_many_forged.roark") == 400; }));
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  CHECK(refused("signature.roark") > 0);
  CHECK(static_cast<double>(refused("signature.roark")) <= 20 * (1 + took_s));
  std::size_t named = 0;
  for (const std::string& each : labs.shark->notices)
    named += each == "another program uses the name of lab roark on the NATS server; its messages are ignored";
  CHECK(named > 0);
  CHECK(named < 5);
  // roark comes back in the midst of it.
  labs.start("roark", {"shark", "lynx", "mole"});
  CHECK(labs.until([&] {
    flood(5);
    return labs.shark->count("roark", "session.opened") >= 2 && labs.others_are_up();
  }));
}

TEST_CASE("a member who says too much is heard no better") {
  // Greetings of ever other streams, pieces of none and long ones of its own, 40 in each turn: the others' links stay
  // up, and for each greeting there is at most one answer.
  WithMole labs;
  labs.mole->meet("shark");
  const auto began = std::chrono::steady_clock::now();
  const std::vector<std::byte> much(30'000, std::byte{'!'});
  StreamId stream = 1000;
  std::uint64_t said = 0;
  labs.check_others([&] {
    for (int i = 0; i < 20; ++i) {
      labs.mole->say_sealed({.greetings = {{"shark", ++stream, 7, true}}}, "shark");
      labs.server.forward(labs.mole->signed_packet({.greetings = {{"shark", ++stream, 7, true}},
                                                    .pieces = {{.yours = 5, .mine = 6, .chunks = {0}}},
                                                    .chunks = {much}},
                                                   "mole"));
      said += 2;
    }
  });
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  CHECK(labs.server.publications().at("arkmesh.dhtf.shark.mole") < said);
  CHECK(static_cast<double>(labs.server.publications().at("arkmesh.dhtf.shark.ALL")) < 200 + 100 * took_s);
}

TEST_CASE("a member who floods is looked at so often and no more") {
  // Thousands of packets that it has signed and sealed itself: counted under its name, and the others lose nothing.
  WithMole labs;
  labs.mole->meet("shark");
  const PacketBody body{.greetings = {{"shark", 5, 6, false}}};
  const auto began = std::chrono::steady_clock::now();
  labs.check_others([&] {
    for (int i = 0; i < 150; ++i) {
      labs.server.forward(labs.mole->signed_packet(body, "mole"));
      labs.server.forward(labs.mole->sealed_packet(body, "shark", "mole"));
    }
  });
  // All of them have come when one that is damaged after them has.
  auto damaged = labs.mole->sealed_packet(body, "shark", "mole");
  damaged.bytes.back() ^= 1;
  CHECK(labs.until([&] {
    labs.server.forward(damaged);
    return labs.shark->count("federation.refused.seal.mole") > 0;
  }));
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  const auto refused = static_cast<double>(labs.shark->count("federation.refused.too_many.mole"));
  CHECK(12'000 - refused <= 5000 * (1 + took_s));
  CHECK(labs.shark->count("federation.refused.too_many.roark") == 0);
}

TEST_CASE("a member who repeats another's greetings makes nobody talk") {
  // What roark said when it met shark, thousands of times, with encrypt: shark answers, and does not say its keys more
  // often for it.
  Meeting meeting;
  std::vector<Message> past;
  meeting.server.published = [&](const Message& message) { past.push_back(message); };
  MeetingLab& shark = meeting.start("shark", {"roark"}, {.encrypt = true});
  meeting.start("roark", {"shark"}, {.encrypt = true});
  REQUIRE(meeting.until([&] { return meeting.all_up(); }));
  meeting.server.published = {};
  const auto to_all = [&] { return meeting.server.publications().at("arkmesh.dhtf.shark.ALL"); };
  const auto before = to_all();
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < 200; ++i) {
    for (const Message& each : past)
      if (each.subject.starts_with("arkmesh.dhtf.roark.")) meeting.server.forward(each);
    meeting.pass(2ms);
  }
  CHECK(to_all() - before <= static_cast<std::uint64_t>(2 + (std::chrono::steady_clock::now() - began) / 200ms));
  CHECK(shark.count("roark", "session.opened") == 1);
}

TEST_CASE("a member who claims what is not so loses its own stream only") {
  // An acknowledgement of what was never sent, a first frame that is no hello, and one that says it has 4 GB: each ends
  // its stream, and is counted under its name.
  struct Row {
    std::string counter;
    std::function<void(RogueMember&)> lie;
  };
  const std::vector<Row> table{
      {"federation.refused.acknowledgement.mole",
       [](RogueMember& mole) {
         Piece piece = mole.relay.piece();
         piece.acknowledged = 1'000'000'000;
         mole.say_sealed({.pieces = {piece}}, "shark");
       }},
      {"session.closed.no_hello", [](RogueMember& mole) { mole.say({encode_frame(FrameKind::heartbeat, {})}); }},
      {"session.closed.bad_header",
       [](RogueMember& mole) { mole.say({std::vector<std::byte>(100, std::byte{0xff})}); }},
  };
  for (const Row& row : table) {
    CAPTURE(row.counter);
    WithMole labs;
    labs.mole->meet("shark");
    row.lie(*labs.mole);
    CHECK(labs.until([&] { return labs.shark->count(row.counter) + labs.shark->count("mole", row.counter) >= 1; }));
    labs.check_others([] {});
  }
}

TEST_CASE("a server that is silent is left for the next of the list") {
  // One that is stopped in the midst of its work: both labs go to the other one, nothing is lost, and it takes a few
  // seconds.
  NatsServerProcess first, second;
  const Meeting::Habits habits{.connect = first.address() + "," + second.address()};
  Meeting meeting;
  MeetingLab& shark = meeting.start("shark", {"roark"}, habits);
  MeetingLab& roark = meeting.start("roark", {"shark"}, habits);
  REQUIRE(meeting.until([&] { return meeting.all_up(); }));
  auto said = say(meeting, shark, 20);
  CHECK(meeting.heard("roark", "shark", said));
  first.pause(true);
  const auto stopped = std::chrono::steady_clock::now();
  CHECK(meeting.until([&] { return shark.count("server.connected") == 2 && roark.count("server.connected") == 2; }));
  MESSAGE("left after " << std::chrono::duration<double>(std::chrono::steady_clock::now() - stopped).count() << " s");
  CHECK(shark.count("server.closed.silent") == 1);
  const auto more = say(meeting, shark, 20);
  said.insert(said.end(), more.begin(), more.end());
  CHECK(meeting.heard("roark", "shark", said));
  meeting.check_settled();
}

TEST_CASE("a server that comes back soon has not been missed") {
  // Killed, and started again within a second, ten messages later: the same session goes on.
  NatsServerProcess server;
  const Meeting::Habits habits{.connect = server.address()};
  Meeting meeting;
  MeetingLab& shark = meeting.start("shark", {"roark"}, habits);
  meeting.start("roark", {"shark"}, habits);
  REQUIRE(meeting.until([&] { return meeting.all_up(); }));
  auto said = say(meeting, shark, 20);
  server.kill();
  CHECK(meeting.until([&] { return shark.count("server.closed.lost") == 1; }));
  const auto more = say(meeting, shark, 10);
  said.insert(said.end(), more.begin(), more.end());
  server.start();
  CHECK(meeting.heard("roark", "shark", said));
  CHECK(shark.count("roark", "session.opened") == 1);
  meeting.check_settled();
}

}  // namespace
}  // namespace arkmesh::gateway
