// The keys of [safety]: when robots of a lab obey others, and when they stop by themselves.
#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::lab {

struct SafetyConfig {
  std::vector<std::string> commands_from;  // labs whose operators may pause and resume robots here, and end the run
  double commands_per_s = 1;               // of each of them, at most
  // Robots that keep real time pause when no new state of any peer was applied for so long; 0: never.
  std::chrono::microseconds pause_after{10'000'000};
  std::chrono::microseconds hung_after{
      3'000'000};        // without a sign of life of a lab its guard tells real robots to stand; 0: never
  double missing = 0.1;  // robots that no camera ever saw and named, as a share of all, or from 1 on a number

  // Of so many robots: how many may never have been seen and named, and the rest counts as all. Never all.
  std::size_t may_be_missing(std::size_t robots) const;

  void fields(const hal::Section& safety);
  // `labs`: shared.labs, `lab` included. From then on commands_from names them one by one.
  void check(const hal::Section& safety, const std::string& lab, const std::vector<std::string>& labs);
};

// Robots that should stand were seen to, but for at most so many that no camera ever saw and named.
bool stand(std::span<const hal::NotStanding> not_seen_to, std::size_t may_be_missing);

}  // namespace arkmesh::lab
