#include "mark/settings.hpp"

#include <fmt/format.h>

#include <boost/asio/ip/address.hpp>
#include <chrono>

#include "hal/arenas/arena_config.hpp"

namespace arkmesh::mark {
namespace {

using namespace std::chrono_literals;

// As the published software is compiled or, ARK-Qt, configured; of the original, whose role is the other one.
double published_side_m(Flavour flavour, Role role, Experiment experiment) {
  const bool original_is_server = role == Role::client;
  if (experiment == Experiment::cre) return original_is_server ? 0.5 : 2.0;
  return flavour == Flavour::ark_qt && !original_is_server ? 0.5 : 1.0;
}

void check_address(const hal::Section& mark, const Settings& s) {
  boost::system::error_code wrong;
  const auto ip = boost::asio::ip::make_address(s.address == "localhost" ? "127.0.0.1" : s.address, wrong);
  if (wrong) mark.refuse("address", "is not an IP address; write one such as 127.0.0.1");
  if (!ip.is_loopback() && !s.allow_plaintext)
    mark.refuse("address",
                "is not on this machine, and M-ARK neither encrypts nor authenticates; use 127.0.0.1 and a tunnel (ssh "
                "-L), or set mark.allow_plaintext = true on a trusted network");
}

void check_arena(const hal::Section& root, const Settings& s) {
  const hal::Section arena = root.section("arena");
  const auto sides = arena.read<hal::ArenaSides>();
  for (const auto& [key, side] : {std::pair{"width_m", sides.width_m}, {"height_m", sides.height_m}})
    if (side != s.side_m)
      arena.refuse(key, fmt::format("must equal mark.side_m = {}, the side of the original's square arena (a constant "
                                    "there; set mark.side_m if yours was built with another)",
                                    s.side_m));
}

void check_period(const hal::Section& root, const lab::RunConfig& run, const Settings& s) {
  if (run.period % s.period != hal::LabTime{0})
    root.section("gate").refuse(
        "period_s", fmt::format("must be a whole multiple of mark.period_s = {}, the original's message period",
                                seconds(s.period)));
}

}  // namespace

double seconds(hal::LabTime t) {
  return static_cast<double>(t.count()) / 1e6;
}

void Settings::fields(const hal::Section& mark) {
  mark.field("flavour", flavour, {.help = "which published program the original runs", .one_of = {"argos", "ark_qt"}});
  mark.field("address", address,
             {.help = "with --server the address to listen on; with --client the address of the original"});
  mark.field("port", port, {.range = {1, 65535}, .help = "TCP port, a constant in the published programs"});
  mark.field("allow_plaintext", allow_plaintext,
             {.help = "allow an address on another machine, although M-ARK neither encrypts nor authenticates"});
  mark.field("period_s", period,
             {.range = {0, 3600},
              .unit = "s",
              .help = "message period of the original: ARGoS's tick",
              .default_is = "0.1 for argos, 2.0 for ark_qt"});
  mark.field("side_m", side_m,
             {.range = {0, 1e3},
              .unit = "m",
              .help = "side of the original's square arena",
              .default_is = "the published one"});
  mark.field("robots", robots, {.range = {1, 400}, .help = "number of robots of an original flying swarm"});
  mark.field("read_bytes", read_bytes,
             {.range = {0, 65536},
              .unit = "bytes",
              .help = "size of the original's read buffer",
              .default_is = "30 in DHTF, 2000 in CRE"});
}

Settings read_settings(const hal::Config& config, const lab::RunConfig& run, Role role, Experiment experiment) {
  const hal::Section root = config.root(), mark = root.section("mark");
  auto s = mark.read<Settings>();
  const bool argos = s.flavour == Flavour::argos;
  if (s.period == hal::LabTime{0}) s.period = argos ? 100ms : 2s;
  s.ahead = run.period;
  if (s.side_m == 0) s.side_m = published_side_m(s.flavour, role, experiment);
  if (s.read_bytes == 0) s.read_bytes = !argos ? 2047 : experiment == Experiment::dhtf ? 30 : 2000;
  if (experiment == Experiment::cre && !argos)
    mark.refuse("flavour",
                "must be \"argos\": the supported version of this flavour has no CRE with positions, and run.scenario "
                "is \"cre\"");
  check_address(mark, s);
  check_arena(root, s);
  check_period(root, run, s);
  return s;
}

const char* name_of(Flavour flavour) {
  return flavour == Flavour::argos ? "ARGoS" : "ARK-Qt";
}

const char* other_of(Role role) {
  return role == Role::server ? "client" : "server";
}

}  // namespace arkmesh::mark
