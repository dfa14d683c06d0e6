// The original's messages as they were captured on the wire, written and read, and split from bytes as TCP brings them.
#include <doctest/doctest.h>

#include <initializer_list>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "mark/splitter.hpp"
#include "mark/vocabulary.hpp"

using namespace arkmesh::mark;

namespace {

std::string bytes(std::initializer_list<int> values) {
  std::string out;
  for (const int value : values) out += static_cast<char>(value);
  return out;
}

// Captured, seed 65 of the published files.
const std::string captured_missing = bytes(
    {0x4d, 0x69, 0x73, 0x73, 0x69, 0x6e, 0x67, 0x20, 0x70, 0x61, 0x72, 0x61, 0x6d, 0x65, 0x74, 0x65, 0x72, 0x73, 0x00});
const std::string captured_init = bytes({0x49, 0x62, 0x63, 0x67, 0x68, 0x69, 0x6a, 0x6b, 0x6f, 0x30, 0x31, 0x30, 0x30,
                                         0x31, 0x30, 0x31, 0x31, 0x30, 0x31, 0x30, 0x31, 0x31, 0x31, 0x30, 0x30, 0x00});
const std::string captured_ack = bytes({0x52, 0x65, 0x63, 0x65, 0x69, 0x76, 0x65, 0x64, 0x20, 0x70,
                                        0x61, 0x72, 0x61, 0x6d, 0x65, 0x74, 0x65, 0x72, 0x73, 0x00});
const std::string captured_empty = bytes({0x00});
const std::string captured_ready = bytes({0x54, 0x30, 0x30, 0x31, 0x30, 0x30, 0x30, 0x30, 0x30, 0x00});
const std::string captured_accomplished = bytes({0x41, 0x30, 0x30, 0x30, 0x30, 0x30, 0x30, 0x30, 0x30, 0x00});
const std::string captured_inactive = bytes({0x41, 0x30, 0x30, 0x31, 0x30, 0x30, 0x30, 0x30, 0x30, 0x00});
const std::string captured_robot = bytes({0x31, 0x39, 0x32, 0x32, 0x30, 0x00});
const std::string captured_robots = std::string(
                                        "19220"
                                        "16100"
                                        "24320"
                                        "29240"
                                        "13290"
                                        "22280"
                                        "13240"
                                        "35350"
                                        "14320"
                                        "24210"
                                        "35250"
                                        "32220"
                                        "27200"
                                        "23130"
                                        "39150"
                                        "38350"
                                        "26260"
                                        "32280"
                                        "13360"
                                        "34160") +
                                    '\0';
const Init init_of_seed_65{.cells = {1, 2, 6, 7, 8, 9, 10, 14},
                           .server_hard = {0, 1, 0, 0, 1, 0, 1, 1},
                           .client_hard = {0, 1, 0, 1, 1, 1, 0, 0}};

Grammar grammar(Role role, Experiment experiment = Experiment::dhtf, Flavour flavour = Flavour::argos,
                std::size_t sites = 8) {
  return {.experiment = experiment, .role = role, .flavour = flavour, .sites = sites, .side_cm = 50};
}

std::string ended(std::string_view text) {
  return std::string(text) + '\0';
}

std::vector<std::string> texts(const std::vector<Message>& messages) {
  std::vector<std::string> out;
  for (const Message& message : messages) out.push_back(message.text);
  return out;
}

}  // namespace

TEST_CASE("captured messages are what is written") {
  // Every text that this side says in a role, with the NUL that ARGoS adds, is byte for byte what was captured.
  CHECK(ended(missing_text(Flavour::argos)) == captured_missing);
  CHECK(ended(to_text(init_of_seed_65)) == captured_init);
  CHECK(ended(ack_text(Flavour::argos)) == captured_ack);
  CHECK(ended(to_text('T', {0, 0, 1, 0, 0, 0, 0, 0})) == captured_ready);
  CHECK(ended(to_text('A', {0, 0, 0, 0, 0, 0, 0, 0})) == captured_accomplished);
  CHECK(ended(to_text('A', {0, 0, 1, 0, 0, 0, 0, 0})) == captured_inactive);
  CHECK(ended(to_text(std::vector<FlyingRobot>{{19, 22, 0}})) == captured_robot);
  CHECK(missing_text(Flavour::ark_qt) == "Missing initialisation");
  CHECK(ack_text(Flavour::ark_qt) == "Received initialisation");
  std::vector<int> active(100, 0);
  active[0] = active[5] = active[7] = 1;
  CHECK(resources_text(active).substr(0, 8) == "01111010");
  CHECK(resources_text(active).size() == 100);
}

TEST_CASE("captured messages are read, in both directions") {
  // Client to server, server to client, ground to flying and back, each whole in one segment.
  Splitter from_client(grammar(Role::server)), from_server(grammar(Role::client));
  CHECK(from_client.feed(captured_missing + captured_ack + captured_ready) ==
        std::vector<Message>{
            {Word::missing, "Missing parameters"}, {Word::ack, "Received parameters"}, {Word::ready, "T00100000"}});
  CHECK(from_server.feed(captured_init + captured_empty + captured_accomplished + captured_inactive) ==
        std::vector<Message>{{Word::init, "Ibcghijko0100101101011100"},
                             {Word::empty, ""},
                             {Word::accomplished, "A00000000"},
                             {Word::accomplished, "A00100000"}});
  CHECK(read_init("Ibcghijko0100101101011100") == init_of_seed_65);
  CHECK(read_levels("T00100000", 8) == std::vector<int>{0, 0, 1, 0, 0, 0, 0, 0});
  Splitter from_flying(grammar(Role::client, Experiment::cre));
  const auto robots = from_flying.feed(captured_robots);
  REQUIRE(robots.size() == 1);
  const auto read = read_robots(robots[0].text, 50);
  REQUIRE(read);
  CHECK(read->size() == 20);
  CHECK(read->front() == FlyingRobot{19, 22, 0});
  CHECK(read->back() == FlyingRobot{34, 16, 0});
  CHECK(ended(to_text(*read)) == captured_robots);
  std::string resources(100, '1');
  resources.replace(0, 8, "01110101");
  Splitter from_ground(grammar(Role::server, Experiment::cre));
  CHECK(texts(from_ground.feed(ended(resources))) == std::vector{resources});
  CHECK(resources_text(*read_resources(resources)) == resources);
  for (const Splitter* each : {&from_client, &from_server, &from_flying, &from_ground})
    CHECK(each->counters().all().empty());
}

TEST_CASE("any number of sites, letters a to p") {
  // M from 1 to 16: what is written is read again, by both grammars.
  for (std::size_t m = 1; m <= 16; ++m) {
    CAPTURE(m);
    Init init;
    for (std::size_t i = 0; i < m; ++i)
      init.cells.push_back(static_cast<int>(i)), init.server_hard.push_back(i % 2),
          init.client_hard.push_back(i % 3 == 0);
    const std::string text = to_text(init);
    CHECK(text.size() == 1 + 3 * m);
    CHECK(read_init(text) == init);
    for (const Flavour flavour : {Flavour::argos, Flavour::ark_qt}) {
      Splitter splitter(grammar(Role::client, Experiment::dhtf, flavour, m));
      const std::string levels = "A" + std::string(m, '1'), end(flavour == Flavour::argos ? 1 : 0, '\0');
      CHECK(texts(splitter.feed(text + end + levels + end + levels + end)) == std::vector{text, levels, levels});
    }
  }
}

TEST_CASE("cut and merged segments give the same messages") {
  // A conversation of each grammar, cut at random places and merged as it comes, byte by byte at worst, is split into
  // what was said.
  struct Case {
    Grammar grammar;
    std::vector<std::string> said;
  };
  const std::string places(100, '1');
  const std::vector<Case> cases = {
      {grammar(Role::server), {"Missing parameters", "Received parameters", "T00100000", "T11111111"}},
      {grammar(Role::client), {"Ibcghijko0100101101011100", "", "A00000000", "A00100000"}},
      {grammar(Role::server, Experiment::dhtf, Flavour::ark_qt),
       {"Missing initialisation", "Received initialisation", "T00100000", "T11111111", "T00000000"}},
      {grammar(Role::client, Experiment::dhtf, Flavour::ark_qt),
       {"Reply: connection established", "Ibcghijko0100101101011100", "Ibcghijko0100101101011100", "A00000000",
        "A00100000", "0"}},
      {grammar(Role::client, Experiment::cre), {"19220", "1922050502"}},
      {grammar(Role::server, Experiment::cre), {places, "0" + places.substr(1)}},
  };
  std::mt19937 dice(3);
  for (const Case& one : cases) {
    std::string all;
    for (const std::string& text : one.said) all += one.grammar.flavour == Flavour::argos ? ended(text) : text;
    for (int round = 0; round < 200; ++round) {
      Splitter splitter(one.grammar);
      std::vector<std::string> heard;
      for (std::size_t at = 0; at < all.size();) {
        const std::size_t n = round == 0 ? 1 : 1 + dice() % 40;
        for (const std::string& text : texts(splitter.feed(std::string_view(all).substr(at, n)))) heard.push_back(text);
        at += n;
      }
      CHECK(heard == one.said);
      CHECK(splitter.counters().all().empty());
      CHECK(splitter.waiting() == 0);
    }
  }
}

TEST_CASE("what is no message is refused, counted with its reason, and the next one is read") {
  struct Case {
    Grammar grammar;
    std::string bytes;
    const char* why;
    std::string next;  // what is read behind it
  };
  const Grammar client = grammar(Role::server), server = grammar(Role::client);
  const Grammar qt_client = grammar(Role::server, Experiment::dhtf, Flavour::ark_qt);
  const Grammar qt_server = grammar(Role::client, Experiment::dhtf, Flavour::ark_qt);
  const std::vector<Case> cases = {
      {client, ended("hello") + ended("T00100000"), "unknown", "T00100000"},
      {client, ended("") + ended("T00100000"), "unknown", "T00100000"},
      {client, ended("A00100000") + ended("T00100000"), "unknown", "T00100000"},  // the server's word
      {client, ended("T001000001") + ended("T00100000"), "levels", "T00100000"},  // over-long
      {client, ended("T0010") + ended("T00100000"), "levels", "T00100000"},       // short
      {client, ended("T0010200x") + ended("T00100000"), "levels", "T00100000"},   // no digit of its
      {client, std::string(1000, 'T') + ended("") + ended("T00100000"), "too_long", "T00100000"},
      {server, ended("Ibcghijko010010110101110") + ended("A00000000"), "init", "A00000000"},   // one digit short
      {server, ended("Icbghijko0100101101011100") + ended("A00000000"), "init", "A00000000"},  // not ascending
      {server, ended("Ibbghijko0100101101011100") + ended("A00000000"), "init", "A00000000"},  // twice
      {server, ended("Ibcghijkq0100101101011100") + ended("A00000000"), "init", "A00000000"},  // beyond p
      {server, ended("I") + ended("A00000000"), "init", "A00000000"},                          // no site
      {qt_client, "zzzT00100000", "unknown", "T00100000"},
      {qt_client, std::string("T0010T00100000"), "levels", "T00100000"},
      {qt_client, std::string("Missing parT00100000"), "unknown", "T00100000"},
      {qt_server, std::string("A001xA00100000"), "levels", "A00100000"},
      {qt_server, std::string("Ibc01xA00100000"), "init", "A00100000"},
      {qt_server, std::string("A00x00000A00100000"), "levels", "A00100000"},  // its zeros do not stop the experiment
      {grammar(Role::client, Experiment::cre), ended("192203") + ended("19220"), "robots", "19220"},
      {grammar(Role::client, Experiment::cre), ended("19223") + ended("19220"), "robots", "19220"},  // commitment 3
      {grammar(Role::client, Experiment::cre), ended("51220") + ended("19220"), "robots", "19220"},  // outside
      {grammar(Role::client, Experiment::cre), ended("-1220") + ended("19220"), "robots", "19220"},
      {grammar(Role::server, Experiment::cre), ended("0101") + ended(std::string(100, '1')), "resources",
       std::string(100, '1')},
      {grammar(Role::server, Experiment::cre), ended(std::string(100, '2')) + ended(std::string(100, '1')), "resources",
       std::string(100, '1')},
  };
  for (const Case& one : cases) {
    CAPTURE(one.bytes);
    for (const std::size_t step : {one.bytes.size(), std::size_t{1}}) {
      Splitter splitter(one.grammar);
      std::vector<std::string> heard;
      for (std::size_t at = 0; at < one.bytes.size(); at += step)
        for (const std::string& text : texts(splitter.feed(std::string_view(one.bytes).substr(at, step))))
          heard.push_back(text);
      CHECK(heard == std::vector{one.next});
      CHECK(splitter.counters()[std::string("mark.refused.") + one.why] >= 1);
      CHECK(splitter.counters()["mark.refused_bytes"] + one.next.size() <= one.bytes.size());
      CHECK_FALSE(splitter.newest_refusal().empty());
    }
  }
}
