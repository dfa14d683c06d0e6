// The settings of DHTF: section [scenario.dhtf], alike in all labs.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::scenarios::dhtf {

enum class Types { random, half, easy, hard };

struct Settings {
  int sites = 8;                                     // M, of the 4x4 cells of the owner's arena
  bool corners = true;                               // cells = "all"; false: "no_corners"
  Types types = Types::random;                       // "half": half of the sites are hard, drawn for each lab by itself
  double site_radius_m = 0.08;                       // shared frame
  hal::LabTime respawn{40'000'000};                  // a completed site is inactive so long
  std::vector<std::int64_t> timeouts_s{30, 40, 60};  // a robot's wait: easy in all labs, hard in some, hard in all
  std::map<std::string, std::vector<std::int64_t>, std::less<>> requirements;  // by lab: robots for easy, hard
  double wall_zone_m = 0.066;      // walls nearer than this are told to a robot; arena metres
  hal::LabTime repeat{1'000'000};  // interval between repetitions to a robot that seems to have missed a message
  double nudge_site_m = 0;         // moves the first site in +x of the shared frame, for control experiments

  void fields(const hal::Section& dhtf);
  void check(const hal::Section& dhtf) const;
};

// Throws ConfigError; every lab of `labs` needs requirements.
Settings read_settings(const hal::Section& dhtf, const std::vector<std::string>& labs);

}  // namespace arkmesh::scenarios::dhtf
