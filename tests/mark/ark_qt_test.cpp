// ARK-Qt: no NUL, no ticks, the wall's clock; messages far enough apart that it never reads two at once.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "mark/dhtf_conversation.hpp"
#include "tests/sim_ode/heard_warnings.hpp"
#include "tests/support/mark/original_bench.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;

namespace {

const mark::Settings table{.flavour = mark::Flavour::ark_qt, .period = 2s, .side_m = 1, .read_bytes = 2047};

}  // namespace

TEST_CASE("ark-qt: as the server, Init until the ack, then a message each two seconds") {
  mark::DhtfServerConversation talk(2);
  OriginalBench bench(table, mark::Role::server, talk);
  bench.link->events->heard("Missing init");
  CHECK(bench.pass(1s).empty());  // the labs have not met: nothing goes before Init
  talk.set_init({.cells = {1, 2}, .server_hard = {0, 1}, .client_hard = {1, 1}});
  CHECK(bench.pass(1s) == std::vector<std::string>{"Ibc0111"});
  CHECK(bench.pass(8s).empty());  // two that it read at once would be another world
  bench.link->events->heard("ialisationReceived initia");
  bench.link->events->heard("lisationT0");
  CHECK(talk.acked());
  CHECK(bench.pass(300ms) == std::vector<std::string>{"A00"});
  bench.link->events->heard("1T10");
  CHECK(talk.ready() == std::vector<int>{1, 0});
  CHECK(bench.pass(8s).size() == 1);  // one that stalls is told nothing more: two at once would kill it
  for (int i = 0; i < 3; ++i) CHECK((bench.link->events->heard("T10"), bench.pass(2s).size()) == 1);
  // What has changed is told sooner, 250 ms after the last at the least.
  bench.link->events->heard("T10");
  talk.set_inactive({1, 0});
  CHECK(bench.pass(600ms) == std::vector<std::string>{"A10"});
  for (int i = 0; i < 10; ++i) {
    talk.set_inactive({i % 2, 0});
    bench.link->events->heard("T10");
    CHECK(bench.pass(100ms).size() <= 1);
  }
  // Nothing while the last is on its way.
  bench.link->has_settled = false;
  bench.link->events->heard("T10");
  CHECK(bench.pass(5s).empty());
  CHECK(bench.counters["mark.held.not_arrived"] > 0);
}

TEST_CASE("ark-qt: as the client, the banner is no answer, and a stop empties its teams") {
  mark::DhtfClientConversation talk(2, mark::Flavour::ark_qt, "lab.toml");
  OriginalBench bench(table, mark::Role::client, talk);
  bench.link->events->heard("Reply: connection establi");
  CHECK(bench.pass(300ms) == std::vector<std::string>{"Missing initialisation"});
  bench.link->events->heard("shedIbc01");
  CHECK_FALSE(talk.may_begin());
  bench.link->events->heard("11Ibc0111");
  CHECK(talk.may_begin());
  talk.go();
  CHECK(bench.pass(200ms) == std::vector<std::string>{"Received initialisation"});
  bench.link->events->heard("A00A10A11A01");
  CHECK(talk.executed() == std::vector<std::int64_t>{1, 1});
  CHECK(talk.inactive() == std::vector<int>{0, 1});
  talk.set_ready({1, 1});
  CHECK(bench.pass(300ms) == std::vector<std::string>{"T10"});  // the inactive site is ready for nobody
  bench.link->events->heard("0");
  CHECK(bench.counters["mark.stopped"] == 1);
  CHECK(bench.original.refusals().all().empty());
}

TEST_CASE("ark-qt: a server that is silent while it holds our acknowledgement hears it once, and then T") {
  // Each 100 ms it sends Init, nothing, or, each two seconds, A, by what it has heard last; T takes the place of the
  // ack.
  mark::DhtfClientConversation talk(2, mark::Flavour::ark_qt, "lab.toml");
  OriginalBench bench(table, mark::Role::client, talk);
  std::string held;
  bool knows_us = false;
  int since_told = 0, told = 0;
  std::vector<std::string> heard;
  const auto pass = [&](int hundreds_of_ms) {
    for (; hundreds_of_ms > 0; --hundreds_of_ms, ++since_told) {
      if (held.starts_with('R')) {
        knows_us = true;
      } else if (!knows_us || held.starts_with('M')) {
        bench.link->events->heard("Ibc0111");
      } else if (since_told >= 20) {
        since_told = 0;
        ++told;
        bench.link->events->heard("A00");
      }
      if (held.starts_with('T')) held.clear();
      for (const std::string& text : bench.pass(100ms)) heard.push_back(held = text);
    }
  };
  const auto acks = [&] { return std::ranges::count(heard, "Received initialisation"); };
  pass(30);
  CHECK(talk.may_begin());
  talk.go();
  pass(100);
  CHECK(acks() == 1);
  CHECK(std::ranges::count(heard, "T00") >= 4);
  CHECK(told >= 4);
  // Its operator begins anew on the same connection.
  knows_us = false;
  pass(50);
  CHECK(acks() == 2);
  CHECK(heard.back() == "T00");
}

TEST_CASE("ark-qt: a server that is started again, while we stay, is heard before it is answered") {
  // What it says before its Init is of a world that may be another one. With the same sites it goes on, with others the
  // run ends by name.
  for (const bool same : {true, false}) {
    CAPTURE(same);
    mark::DhtfClientConversation talk(2, mark::Flavour::ark_qt, "lab.toml");
    OriginalBench bench(table, mark::Role::client, talk);
    bench.link->events->heard("Reply: connection establishedIbc0111");
    talk.keep();
    talk.go();
    CHECK(bench.pass(200ms) == std::vector<std::string>{"Received initialisation"});
    bench.link->events->heard("A00");
    bench.link->is_up = false;
    bench.link->events->gone("it closed its connection");
    bench.pass(1s);
    bench.link->is_up = true;
    bench.link->events->came();
    bench.link->events->heard("Reply: connection established");
    CHECK(bench.pass(1s) == std::vector<std::string>{"Missing initialisation"});
    bench.link->events->heard("A11");
    CHECK(talk.executed() == std::vector<std::int64_t>{0, 0});
    bench.link->events->heard(same ? "Ibc0111" : "Ibd0111");
    if (same) {
      CHECK(bench.pass(200ms) == std::vector<std::string>{"Received initialisation"});
      bench.link->events->heard("A10");
      CHECK(talk.executed() == std::vector<std::int64_t>{1, 0});
      CHECK(talk.conflict().empty());
    } else {
      CHECK(talk.conflict() ==
            "start all labs again: the original server returned with another Init: 'Ibc0111' before, 'Ibd0111' now");
    }
  }
}

TEST_CASE("ark-qt: a client that comes back with sites it had goes on, and that is said") {
  // Another program, which other labs had told its sites, would look the same.
  const sim_ode::Heard heard;
  mark::DhtfServerConversation talk(2);
  OriginalBench bench(table, mark::Role::server, talk);
  talk.set_init({.cells = {1, 2}, .server_hard = {0, 1}, .client_hard = {1, 1}});
  bench.link->events->heard("Received initialisationT01");
  CHECK_FALSE(heard.says("sites"));
  bench.link->events->gone("it closed its connection");
  bench.link->events->came();
  bench.link->events->heard("T11");
  CHECK(talk.ready() == std::vector<int>{1, 1});
  CHECK(talk.conflict().empty());
  CHECK(heard.says(
      "continues with the sites of an earlier connection; if they came from other labs, restart it and all labs"));
}

TEST_CASE("ark-qt: an original that ends its messages is ARGoS, and the run ends by name") {
  mark::DhtfClientConversation talk(2, mark::Flavour::ark_qt, "lab.toml");
  OriginalBench bench(table, mark::Role::client, talk);
  bench.link->events->heard(std::string("Ibc0111\0\0\0\0", 11));  // NULs alone may be anything
  CHECK(talk.conflict().empty());
  bench.link->events->heard(std::string("A00\0A00\0", 8));
  CHECK(talk.conflict() ==
        "the original M-ARK server (ARK-Qt) ends its messages with NUL, so it is ARGoS; set mark.flavour = \"argos\"");
}

TEST_CASE("ark-qt: time in which labs stand still has no lab time") {
  // Labs are paused for 20 s at lab time 1 s: a period of 2 s is caught up with, and 18 s are not.
  mark::DhtfServerConversation talk(2);
  OriginalBench bench(table, mark::Role::server, talk);
  talk.set_init({.cells = {1, 2}, .server_hard = {0, 1}, .client_hard = {1, 1}});
  CHECK_FALSE(bench.original.reached(100ms));
  bench.link->events->heard("Received initialisationT11");
  bench.pass(1s);
  CHECK(bench.original.reached(1s));
  for (int i = 0; i < 9; ++i) bench.link->events->heard("T11"), bench.pass(2s);
  CHECK(talk.ready() == std::vector<int>{1, 1});
  bench.link->events->heard("T01");
  bench.pass(2s);
  CHECK(talk.ready() == std::vector<int>{0, 1});
  CHECK(bench.counters["mark.skipped.ms"] >= 17'900);
  CHECK(bench.counters["mark.skipped.ms"] <= 18'100);
  CHECK(bench.original.reached(3s));
  CHECK_FALSE(bench.original.reached(3200ms));
}

TEST_CASE("ark-qt: lab time is the wall's") {
  mark::DhtfServerConversation talk(2);
  OriginalBench bench(table, mark::Role::server, talk);
  CHECK_FALSE(bench.original.reached(100ms));
  bench.link->events->heard("T00T00T00T00");  // messages are no ticks
  CHECK_FALSE(bench.original.reached(100ms));
  bench.wall.wait_until(bench.wall.now() + 100ms);
  CHECK(bench.original.reached(100ms));
  CHECK_FALSE(bench.original.reached(200ms));
}

TEST_CASE("ark-qt: a table that is connected and says nothing more counts as gone until it speaks") {
  // Lab time is not its own: without this, teams that it had last would be ready for ever.
  mark::DhtfServerConversation talk(2);
  OriginalBench bench(table, mark::Role::server, talk);
  talk.set_init({.cells = {1, 2}, .server_hard = {0, 1}, .client_hard = {1, 1}});
  bench.pass(60s);  // one that logs nothing says nothing before Init
  CHECK_FALSE(bench.original.reached(100ms));
  CHECK_FALSE(bench.original.away_since());
  bench.link->events->heard("Received initialisationT11");
  for (auto t = 1s; t < 6s; t += 1s) CHECK((bench.pass(1s), bench.original.reached(t)));
  bench.pass(900ms);
  CHECK(talk.ready() == std::vector<int>{1, 1});
  bench.pass(200ms);
  CHECK(talk.ready() == std::vector<int>{0, 0});
  CHECK(bench.original.away_since());
  CHECK_FALSE(bench.original.reached(6s));
  CHECK(bench.original.absence().find("connected but has sent nothing for 6 s") != std::string::npos);
  bench.link->events->heard("T01");
  CHECK(bench.original.reached(6s));
  CHECK(talk.ready() == std::vector<int>{0, 1});
  CHECK(bench.original.absence().empty());
}
