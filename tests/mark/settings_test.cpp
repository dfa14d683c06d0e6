// What the original cannot follow is refused before anything starts, with both names.
#include <doctest/doctest.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "lab/run_config.hpp"
#include "mark/stand_in.hpp"
#include "tests/support/labs/dhtf_configs.hpp"
#include "tests/support/mark/scripted_link.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

namespace {

// The sentence with which the stand-in refuses these overrides of a file in experiments/mark; empty when it is made.
std::string refusal(mark::Role role, const std::string& folder, const std::vector<std::string>& overrides) {
  tests::ScriptedNetwork nobody;
  mark::StandIn stand_in(role, [&](hal::EventLoop&, const mark::Settings&, mark::Role) {
    return std::make_unique<tests::ScriptedLink>(nobody);
  });
  hal::EventLoop loop;
  try {
    const auto config = hal::Config::from_file(tests::experiments() / "mark" / folder / "argos.toml", overrides);
    const auto made = stand_in.make(config, config.root().read<lab::RunConfig>(), loop);
    CHECK(made.arena->info().can_wait == false);
    CHECK(made.arena->info().platform == "m-ark");
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("settings that cannot agree are refused, and both are named") {
  // One row for each rule: the overrides, and two things that the sentence names.
  using mark::Role;
  struct Case {
    Role role;
    std::string folder;
    std::vector<std::string> overrides;
    std::string first, second;
  };
  const std::string ark_qt = "mark.flavour=ark_qt";
  const std::vector<Case> cases = {
      {Role::server, "dhtf", {"arena.width_m=0.5"}, "arena.width_m = 0.5", "mark.side_m = 1"},
      {Role::server, "dhtf", {"arena.height_m=2.0"}, "arena.height_m = 2", "mark.side_m = 1"},
      {Role::server, "dhtf", {ark_qt}, "arena.width_m = 1", "mark.side_m = 0.5"},
      {Role::server, "cre_ground", {"arena.width_m=1.0"}, "arena.width_m = 1", "mark.side_m = 2"},
      {Role::client, "cre_flying", {"arena.width_m=1.0"}, "arena.width_m = 1", "mark.side_m = 0.5"},
      {Role::server, "dhtf", {"gate.period_s=0.25"}, "gate.period_s = 0.25", "mark.period_s = 0.1"},
      {Role::server,
       "dhtf",
       {ark_qt, "gate.period_s=1.0", "arena.width_m=0.5", "arena.height_m=0.5"},
       "gate.period_s = 1",
       "mark.period_s = 2"},
      {Role::server, "dhtf", {"scenario.dhtf.sites=10"}, "scenario.dhtf.sites = 10", "mark.read_bytes = 30"},
      {Role::server, "dhtf", {"scenario.dhtf.cells=all"}, "scenario.dhtf.cells = \"all\"", "no_corners"},
      {Role::server, "dhtf", {"shared.owner=argos"}, "shared.owner = \"argos\"", "client"},
      {Role::client, "dhtf", {}, "shared.owner = \"shark\"", "must be \"argos\""},
      {Role::server, "cre_ground", {"scenario.cre.grid=12"}, "scenario.cre.grid = 12", "100 places"},
      {Role::client, "cre_ground", {"mark.side_m=2.0"}, "roles.flying = \"sky\"", "must be \"argos\""},
      {Role::server, "cre_flying", {"mark.side_m=0.5"}, "roles.ground = \"meadow\"", "must be \"argos\""},
      {Role::server, "cre_ground", {ark_qt}, "mark.flavour = \"ark_qt\"", "run.scenario is \"cre\""},
      {Role::client,
       "cre_flying",
       {"mark.side_m=1.0", "arena.width_m=1.0", "arena.height_m=1.0"},
       "mark.side_m = 1",
       "two digits"},
      {Role::server, "dhtf", {"mark.address=0.0.0.0"}, "mark.address = \"0.0.0.0\"", "mark.allow_plaintext = true"},
      {Role::client,
       "dhtf",
       {"shared.owner=argos", "mark.address=192.0.2.7"},
       "mark.address = \"192.0.2.7\"",
       "mark.allow_plaintext = true"},
      {Role::server, "dhtf", {"mark.address=table.example.org"}, "mark.address", "IP address"},
  };
  for (const Case& one : cases) {
    CAPTURE(one.overrides);
    const std::string sentence = refusal(one.role, one.folder, one.overrides);
    CHECK_MESSAGE(sentence.find(one.first) != std::string::npos, sentence);
    CHECK_MESSAGE(sentence.find(one.second) != std::string::npos, sentence);
  }
}

TEST_CASE("examples with originals of CRE end before these do") {
  // Published runs say something 9000 times, first before lab time begins; what comes later is never said.
  for (const char* folder : {"cre_ground", "cre_flying"}) {
    const auto config = hal::Config::from_file(tests::experiments() / "mark" / folder / "argos.toml", {});
    const auto run = config.root().read<lab::RunConfig>();
    CHECK(run.period * run.last_period < 900s);
    CHECK(run.period * run.last_period >= 800s);
  }
}

TEST_CASE("the files of experiments/mark, and what its keys allow, are taken") {
  // Each file as it is; and other machines where that is said in words, ARK-Qt's table, more sites for a rebuilt
  // client.
  using mark::Role;
  CHECK(refusal(Role::server, "dhtf", {}).empty());
  CHECK(refusal(Role::client, "dhtf", {"shared.owner=argos"}).empty());
  CHECK(refusal(Role::server, "cre_ground", {}).empty());
  CHECK(refusal(Role::client, "cre_flying", {}).empty());
  CHECK(refusal(Role::server, "dhtf", {"mark.address=0.0.0.0", "mark.allow_plaintext=true"}).empty());
  CHECK(refusal(Role::server, "dhtf", {"mark.flavour=ark_qt", "arena.width_m=0.5", "arena.height_m=0.5"}).empty());
  CHECK(refusal(Role::client, "dhtf", {"mark.flavour=ark_qt", "shared.owner=argos"}).empty());
  CHECK(refusal(Role::server, "dhtf", {"scenario.dhtf.sites=9"}).empty());
  CHECK(refusal(Role::server, "dhtf", {"scenario.dhtf.sites=12", "mark.read_bytes=60"}).empty());
  CHECK(refusal(Role::client, "dhtf", {"scenario.dhtf.sites=12", "shared.owner=argos"}).empty());
  // What another arena was configured with may stay in the file.
  CHECK(refusal(Role::server, "dhtf", {"arena.use=ode", "arena.robots=12", "arena.ode.friction=0.5"}).empty());
}
