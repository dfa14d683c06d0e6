// What a lab's configuration says about its run and the world it shares: [lab], [run], [shared], [gate],
// [safety], [sensors].
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "hal/arenas/projection.hpp"
#include "hal/bus/participants.hpp"
#include "hal/config/config.hpp"
#include "hal/types.hpp"
#include "lab/exchange/exchange.hpp"
#include "lab/safety_config.hpp"
#include "lab/sensor_config.hpp"

namespace arkmesh::lab {

struct RunConfig : hal::Participants {
  std::string scenario;    // run.scenario, a name of the catalogue
  std::uint64_t seed = 1;  // one for all labs
  hal::LabTime duration{1'800'000'000};
  std::uint32_t last_period = 0;                                    // K = duration / period, a whole number
  std::map<std::string, hal::Projection, std::less<>> projections;  // one for each lab, also those that take no part
  hal::LabTime period{2'000'000};                                   // gate.period_s
  Exchange exchange;                                                // gate.exchange, .up_period_s, .down_period_s
  std::uint32_t slack = 0;
  bool require_strict = false;  // gate.mode = "strict"
  std::chrono::microseconds patience{600'000'000};
  enum class OnPeerLost { pause, go_on, end } on_peer_lost = OnPeerLost::pause;  // in free mode; strict: end
  // To other labs: of the gateway, and of LCM, whose receivers join no longer ones.
  std::size_t max_message_bytes = 1 << 24;
  std::vector<std::string> absent;        // labs that a file names and that take no part, for people; `run` says so
  hal::LabTime absent_after{10'000'000};  // robots.absent_s
  SafetyConfig safety;
  SensorConfig sensors;
  std::filesystem::path operator_key;  // its file (OperatorKey); empty: the usual one

  void fields(const hal::Section& root);
  void check(const hal::Section& root);
};

// Everything that all labs must have alike, as state 0 carries it: run.*, shared.*, gate.period_s, gate.slack,
// gate.exchange and its periods, scenario.*. Call it after the scenario was made, so that its keys are in force.
std::map<std::string, std::string, std::less<>> shared_settings(const hal::Config& config);

}  // namespace arkmesh::lab
