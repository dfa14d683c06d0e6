// The arena whose time is the original's keeps what every arena promises.
#include <doctest/doctest.h>

#include <chrono>
#include <deque>
#include <memory>
#include <utility>

#include "mark/cre_conversation.hpp"
#include "mark/dhtf_conversation.hpp"
#include "mark/original_arena.hpp"
#include "tests/conformance/arena_conformance.hpp"
#include "tests/conformance/arena_repeats.hpp"
#include "tests/support/mark/original_bench.hpp"
#include "tests/support/mark/scripted_link.hpp"

using namespace arkmesh;

namespace {

// An original flying swarm of six, and the way to it.
struct FlyingPeer {
  tests::CreOriginalFlying original{4, 6};
  tests::ScriptedNetwork network{.options = {}, .original = &original};
};

// Arenas look at them as long as they live.
std::deque<FlyingPeer>& peers() {
  static std::deque<FlyingPeer> all;
  return all;
}

std::unique_ptr<hal::Arena> arena_of_an_original() {
  FlyingPeer& peer = peers().emplace_back();
  peer.network.original = &peer.original;
  auto talk = std::make_unique<mark::CreClientConversation>(6, 50, "lab.toml");
  mark::OriginalParts parts;
  parts.flying = talk.get();
  parts.conversation = std::move(talk);
  parts.link = std::make_unique<tests::ScriptedLink>(peer.network);
  parts.settings = {.period = std::chrono::milliseconds(100), .side_m = 0.5, .robots = 6, .read_bytes = 2000};
  parts.role = mark::Role::client;
  parts.grammar = {.experiment = mark::Experiment::cre, .role = mark::Role::client};
  lab::RunConfig run;
  run.lab = "lab";
  return std::make_unique<mark::OriginalArena>(std::move(parts), run);
}

}  // namespace

TEST_CASE("the arena of an original conforms") {
  // Every check of tests/conformance; its wall is the original's ticks.
  const tests::ArenaRow row{"m-ark", arena_of_an_original, false, true, [](hal::Arena&) {
                              return std::chrono::microseconds(100'000 * peers().back().original.ticks);
                            }};
  for (const auto check : {tests::check_info, tests::check_frame_zero, tests::check_frames, tests::check_latest,
                           tests::check_limits, tests::check_registers, tests::check_commands,
                           tests::check_waits_for_nobody, tests::check_repeatable, tests::check_pace})
    check(row);
}

TEST_CASE("an original that is there and says nothing that it may say is waited for by name") {
  // A table, which sends no NUL, where ARGoS is expected: the likeliest mistake.
  tests::BenchWall wall;
  mark::OriginalParts parts;
  parts.conversation = std::make_unique<mark::DhtfServerConversation>(8);
  auto made = std::make_unique<tests::BenchLink>();
  tests::BenchLink& link = *made;
  parts.link = std::move(made);
  parts.settings = {.period = std::chrono::milliseconds(100), .side_m = 1, .read_bytes = 30};
  mark::OriginalArena arena(std::move(parts), {}, wall);
  link.is_up = true;
  link.events->came();
  REQUIRE(arena.advance_to(hal::LabTime{0}));
  for (int i = 0; i < 4; ++i) link.events->heard("Missing initialisation");
  arena.serve();
  CHECK_FALSE(arena.advance_to(std::chrono::milliseconds(100)));
  CHECK(arena.waiting_for().empty());  // it may only be slow
  wall.wait_until(wall.now() + std::chrono::milliseconds(5100));
  CHECK(arena.waiting_for().find("which is connected but has sent nothing for 5 s") != std::string::npos);
  CHECK(arena.waiting_for().find("for 5 s except 88 bytes without an end") != std::string::npos);
  CHECK(arena.waiting_for().find("an original that sends no NUL bytes is ARK-Qt (mark.flavour)") != std::string::npos);
  link.events->heard(std::string("\0T00000000\0", 11));
  CHECK(arena.waiting_for().empty());
}

TEST_CASE("an original server is waited for by what is missing: itself, or its Init") {
  tests::BenchWall wall;
  mark::OriginalParts parts;
  parts.conversation = std::make_unique<mark::DhtfClientConversation>(8, mark::Flavour::argos, "lab.toml");
  auto made = std::make_unique<tests::BenchLink>();
  tests::BenchLink& link = *made;
  parts.link = std::move(made);
  parts.settings = {.period = std::chrono::milliseconds(100), .side_m = 1, .read_bytes = 30};
  parts.role = mark::Role::client;
  parts.grammar = {.role = mark::Role::client};
  mark::OriginalArena arena(std::move(parts), {}, wall);
  CHECK(arena.waiting_for() == "the original M-ARK server (ARGoS) at 127.0.0.1:7001");
  link.is_up = true;
  link.events->came();
  CHECK(arena.waiting_for() == "the Init of the original M-ARK server (ARGoS)");
  wall.wait_until(wall.now() + std::chrono::milliseconds(5100));
  CHECK(arena.waiting_for() ==
        "the Init of the original M-ARK server (ARGoS), which is connected but has sent nothing for 5 s");
}
