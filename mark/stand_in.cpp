#include "mark/stand_in.hpp"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "hal/time/loop_time.hpp"
#include "mark/cre_lab.hpp"
#include "mark/dhtf_lab.hpp"
#include "mark/tcp_link.hpp"

namespace arkmesh::mark {
namespace {

using namespace std::chrono_literals;

constexpr double flying_share = 0.25;  // of the ground arena's side: the original's constant

// Keys of other arenas, which the lab may have been run with before.
void leave_alone_other_arenas(const hal::Section& root) {
  for (const char* key : {"use", "robots", "frame_period_s", "pace", "ode", "kilobot", "emulated", "replay", "shape",
                          "corners", "obstacles", "objects"})
    root.section("arena").leave_alone(key);
}

}  // namespace

StandIn::MakeLink StandIn::make_link() {
  return [](hal::EventLoop& loop, const Settings& s, Role role) { return make_tcp_link(loop, s, role); };
}

StandIn::StandIn(Role role, MakeLink link, hal::WallTime& wall) : role_(role), link_(std::move(link)), wall_(wall) {}

StandIn::Made StandIn::make(const hal::Config& config, const lab::RunConfig& run, hal::EventLoop& loop) {
  loop_ = &loop;
  leave_alone_other_arenas(config.root());
  const bool is_dhtf = run.scenario == "dhtf";
  if (!is_dhtf && run.scenario != "cre")
    config.root().section("run").refuse("scenario", "must be \"dhtf\" or \"cre\", the scenarios of the original");
  OriginalParts parts;
  parts.role = role_;
  parts.settings = read_settings(config, run, role_, is_dhtf ? Experiment::dhtf : Experiment::cre);
  parts.grammar = {.experiment = is_dhtf ? Experiment::dhtf : Experiment::cre,
                   .role = role_,
                   .flavour = parts.settings.flavour,
                   .sites = 0,
                   .side_cm = static_cast<int>(parts.settings.side_m * 100 + 0.5)};
  return is_dhtf ? make_dhtf(config, run, std::move(parts)) : make_cre(config, run, std::move(parts));
}

std::unique_ptr<hal::Arena> StandIn::make_arena(OriginalParts parts, const lab::RunConfig& run) {
  parts.link = link_(*loop_, parts.settings, role_);
  conversation_ = parts.conversation.get();
  auto arena = std::make_unique<OriginalArena>(std::move(parts), run, wall_);
  arena_ = arena.get();
  return arena;
}

// ---------------------------------------------------------------- DHTF

StandIn::Made StandIn::make_dhtf(const hal::Config& config, const lab::RunConfig& run, OriginalParts parts) {
  const hal::Section root = config.root(), section = root.section("scenario").section("dhtf");
  const auto settings = scenarios::dhtf::read_settings(section, run.labs);
  const auto sites = static_cast<std::size_t>(settings.sites);
  const bool owns = run.owner == run.lab;
  const Flavour flavour = parts.settings.flavour;
  if (run.labs.size() < 2) root.section("shared").refuse("labs", "names no other lab, but the original needs one");
  if (owns != (role_ == Role::client))
    root.section("shared").refuse(
        "owner", owns ? "must be another lab: the original is the client here, and only its server decides the sites"
                      : fmt::format("must be \"{}\": the original is the server here and decides the sites", run.lab));
  if (settings.corners) section.refuse("cells", "must be \"no_corners\": the original never has sites in the corners");
  // Init and levels with their NUL.
  const std::size_t most = (static_cast<std::size_t>(parts.settings.read_bytes) - 2) / 3;
  if (flavour == Flavour::argos && role_ == Role::server && sites > most)
    section.refuse(
        "sites",
        fmt::format(
            "exceeds what the original client can read: its buffer (mark.read_bytes = {}) holds an Init of {} sites",
            parts.settings.read_bytes, most));
  parts.grammar.sites = sites;
  Made made;
  if (role_ == Role::server) {
    auto talk = std::make_unique<DhtfServerConversation>(sites);
    made.scenario = std::make_unique<DhtfClientLab>(settings, *talk);
    parts.conversation = std::move(talk);
  } else {
    auto talk = std::make_unique<DhtfClientConversation>(sites, flavour, config.file().string());
    made.scenario = std::make_unique<DhtfServerLab>(settings, *talk);
    parts.conversation = std::move(talk);
  }
  made.arena = make_arena(std::move(parts), run);
  return made;
}

// ---------------------------------------------------------------- CRE

StandIn::Made StandIn::make_cre(const hal::Config& config, const lab::RunConfig& run, OriginalParts parts) {
  const hal::Section root = config.root(), section = root.section("scenario").section("cre");
  const auto settings = scenarios::cre::read_settings(section, run.labs);
  const std::string& played = role_ == Role::server ? settings.roles.ground : settings.roles.flying;
  if (played != run.lab)
    section.refuse(role_ == Role::server ? "roles.ground" : "roles.flying",
                   fmt::format("must be \"{}\": the original is the {} here, which is the {} swarm", run.lab,
                               other_of(role_), role_ == Role::server ? "ground" : "flying"));
  if (static_cast<std::size_t>(settings.grid) * static_cast<std::size_t>(settings.grid) != places)
    section.refuse("grid", "must be 10: the original has 100 places");
  const double flying_side_m = role_ == Role::server ? parts.settings.side_m * flying_share : parts.settings.side_m;
  if (flying_side_m >= 1)
    root.section("mark").refuse("side_m",
                                "must give a flying arena below 1 m: the original writes centimetres with two digits");
  Made made;
  if (role_ == Role::server) {
    auto talk = std::make_unique<CreServerConversation>();
    made.scenario = std::make_unique<CreGroundLab>(settings, *talk, flying_side_m);
    parts.conversation = std::move(talk);
  } else {
    auto talk = std::make_unique<CreClientConversation>(static_cast<std::size_t>(parts.settings.robots),
                                                        parts.grammar.side_cm, config.file().string());
    made.scenario = std::make_unique<CreFlyingLab>(settings, *talk);
    parts.flying = talk.get();
    parts.conversation = std::move(talk);
  }
  made.arena = make_arena(std::move(parts), run);
  return made;
}

// ---------------------------------------------------------------- after the end

void StandIn::stay(hal::StopRequest& stop) {
  if (!arena_) return;
  hal::LoopTime time(*loop_);
  arena_->end();
  while (is_connected() && !stop.stopped()) {
    time.wait_for_anything(time.now() + 20ms);
    arena_->serve();
  }
}

}  // namespace arkmesh::mark
