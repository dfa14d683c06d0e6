// ARGoS: its messages are ticks; it is told one thing for each, never more than one read takes.
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "mark/dhtf_conversation.hpp"
#include "tests/support/mark/original_bench.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;

namespace {

const mark::Settings simulator{.flavour = mark::Flavour::argos, .period = 100ms, .side_m = 1, .read_bytes = 30};

std::string nul(std::string_view text) {
  return std::string(text) + '\0';
}

std::string times(int n, const std::string& text) {
  std::string out;
  for (int i = 0; i < n; ++i) out += text;
  return out;
}

}  // namespace

TEST_CASE("argos: nothing is said before it speaks, and nothing goes before Init") {
  mark::DhtfServerConversation talk(2);
  OriginalBench bench(simulator, mark::Role::server, talk);
  CHECK(bench.pass(5s).empty());
  CHECK(bench.hear(nul("Missing parameters")).empty());  // the labs have not met
  talk.set_init({.cells = {1, 2}, .server_hard = {0, 1}, .client_hard = {1, 1}});
  CHECK(bench.pass(5s) == std::vector{nul("Ibc0111")});  // for the tick that had no answer yet
  CHECK(bench.hear(nul("Missing parameters")) == std::vector{nul("Ibc0111")});
  CHECK(bench.pass(5s).empty());  // one for each tick, however long that takes
  CHECK(bench.hear(nul("Received parameters")) == std::vector{nul("A00")});
}

TEST_CASE("argos: a burst is one answer, and what it may not have read is never more than a read") {
  // Fifty ticks that come at once are answered once.
  mark::DhtfClientConversation talk(2, mark::Flavour::argos, "lab.toml");
  OriginalBench bench(simulator, mark::Role::client, talk);
  CHECK(bench.hear(nul("Ibc0111")) == std::vector{nul("Missing parameters")});
  talk.go();
  CHECK(bench.hear(times(50, nul("Ibc0111"))) == std::vector{nul("Received parameters")});
  // Two messages of 19 and 20 bytes do not fit into one read: the second waits until two more ticks show that it reads.
  mark::DhtfClientConversation other(2, mark::Flavour::argos, "lab.toml");
  OriginalBench slow(simulator, mark::Role::client, other);
  CHECK(slow.hear(nul("Ibc0111")).size() == 1);
  CHECK(slow.hear(nul("Ibc0111")).empty());
  CHECK(slow.counters["mark.held.unread"] == 1);
  CHECK(slow.hear(nul("Ibc0111")).size() == 1);
  // Nothing while the last is on its way.
  slow.link->has_settled = false;
  CHECK(slow.hear(times(9, nul("Ibc0111"))).empty());
  CHECK(slow.counters["mark.held.not_arrived"] == 1);
}

TEST_CASE("argos: its messages are lab time, in their order") {
  // Before lab time begins they have none. Then a message is 0.1 s, whatever came merged, and is heard at its time.
  mark::DhtfClientConversation talk(2, mark::Flavour::argos, "lab.toml");
  OriginalBench bench(simulator, mark::Role::client, talk);
  bench.hear(times(20, nul("Ibc0111")));
  CHECK_FALSE(bench.original.reached(100ms));
  talk.go();
  bench.hear(nul("A00") + nul("A10") + nul("A11") + "A0");
  CHECK(talk.inactive() == std::vector<int>{0, 0});
  CHECK(bench.original.reached(100ms));
  CHECK(talk.inactive() == std::vector<int>{0, 0});
  CHECK(bench.original.reached(200ms));
  CHECK(talk.inactive() == std::vector<int>{1, 0});
  CHECK(bench.original.reached(300ms));
  CHECK(talk.executed() == std::vector<std::int64_t>{1, 1});
  CHECK_FALSE(bench.original.reached(400ms));
  bench.wall.wait_until(bench.wall.now() + 1h);  // the wall is no clock of it
  CHECK_FALSE(bench.original.reached(400ms));
  bench.hear(nul("1"));
  CHECK(bench.original.reached(400ms));
  // What it refused is no tick.
  bench.hear(nul("hello") + nul("A0000"));
  CHECK_FALSE(bench.original.reached(500ms));
  CHECK(bench.original.refusals()["mark.refused.unknown"] == 1);
  CHECK(bench.original.refusals()["mark.refused.levels"] == 1);
}

TEST_CASE("argos: ticks that come while labs stand still have no lab time, and that is said") {
  // A period of 2 s is 20 ticks. Of 500 ticks that come at once 480 are too many: what they say is heard now, so that
  // tasks done meanwhile are known, and lab time does not jump.
  mark::DhtfClientConversation talk(2, mark::Flavour::argos, "lab.toml");
  OriginalBench bench(simulator, mark::Role::client, talk);
  bench.hear(nul("Ibc0111"));
  talk.go();
  bench.hear(nul("A00"));
  CHECK_FALSE(bench.original.reached(100ms));
  talk.set_ready({1, 1});
  CHECK(bench.hear(times(20, nul("A00"))) == std::vector{nul("T11")});
  CHECK(bench.counters["mark.skipped.ms"] == 0);
  bench.hear(times(20, nul("A00")) + times(440, nul("A01")) + times(20, nul("A00")));
  CHECK(bench.counters["mark.skipped.ms"] == 48'000);
  CHECK(talk.executed() == std::vector<std::int64_t>{0, 1});
  CHECK(bench.hear(nul("A00")) == std::vector{nul("T00")});  // teams of labs that stand still are no evidence
  CHECK(bench.original.reached(2s));
  CHECK_FALSE(bench.original.reached(2100ms));
  talk.set_ready({1, 1});
  CHECK(bench.hear(nul("A00")) == std::vector{nul("T11")});
  CHECK(bench.original.reached(2100ms));
  CHECK(talk.conflict().empty());
  // The same when it goes right afterwards.
  bench.hear(times(100, nul("A00")));
  bench.link->events->heard(times(1000, nul("A10")));
  bench.link->is_up = false;
  bench.link->events->gone("it closed its connection");
  CHECK(talk.executed() == std::vector<std::int64_t>{1, 1});
  CHECK(bench.original.reached(4100ms));
  CHECK_FALSE(bench.original.reached(4200ms));
}

TEST_CASE("argos: an original server that comes with other sites before there is a world may have them") {
  mark::DhtfClientConversation talk(2, mark::Flavour::argos, "lab.toml");
  OriginalBench bench(simulator, mark::Role::client, talk);
  bench.hear(nul("Ibc0111"));
  bench.link->events->gone("it closed its connection");
  bench.link->events->came();
  bench.hear(nul("Ibd0111"));
  CHECK(talk.conflict().empty());
  CHECK(talk.init()->cells == std::vector<int>{1, 3});
  talk.keep();
  bench.hear(nul("Ibd0110"));
  CHECK(talk.conflict() ==
        "start all labs again: the original server returned with another Init: 'Ibd0111' before, 'Ibd0110' now");
}

TEST_CASE("argos: what it cannot read at once is not sent") {
  mark::Settings small = simulator;
  small.read_bytes = 7;
  mark::DhtfServerConversation talk(2);
  OriginalBench bench(small, mark::Role::server, talk);
  talk.set_init({.cells = {1, 2}, .server_hard = {0, 1}, .client_hard = {1, 1}});
  CHECK(bench.hear(nul("Missing parameters")).empty());
  CHECK(bench.counters["mark.not_sent.too_long"] == 1);
}
