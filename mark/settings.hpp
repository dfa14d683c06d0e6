// [mark]: the original peer as it was built and where it is, and which settings of the lab's file it cannot follow.
#pragma once

#include <cstdint>
#include <string>

#include "hal/config/config.hpp"
#include "hal/types.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::mark {

// What this side is to the original; the original is the other.
enum class Role : std::uint8_t { server, client };
enum class Flavour : std::uint8_t { argos, ark_qt };
enum class Experiment : std::uint8_t { dhtf, cre };

struct Settings {
  Flavour flavour = Flavour::argos;
  std::string address = "127.0.0.1";  // server: of this machine, where the original comes; client: where it is
  std::uint16_t port = 7001;          // a constant in the original
  bool allow_plaintext = false;
  hal::LabTime period{0};         // between two messages of the original; 0: its flavour's
  hal::LabTime ahead{2'000'000};  // by what it may be before lab time: gate.period_s
  double side_m = 0;              // of the original's square arena; 0: the published one's
  int robots = 20;                // of an original flying swarm
  int read_bytes = 0;             // what it reads at once; 0: the published one's

  void fields(const hal::Section& mark);
};

// Reads [mark], fills in what the published software was built with, and refuses what the original cannot follow, by
// both names. Throws ConfigError.
Settings read_settings(const hal::Config& config, const lab::RunConfig& run, Role role, Experiment experiment);

double seconds(hal::LabTime t);
// "ARGoS" or "ARK-Qt".
const char* name_of(Flavour flavour);
// What the original is: "server" when this side is the client.
const char* other_of(Role role);

}  // namespace arkmesh::mark
