// result.json: what a run was and gave. See docs/formats.md.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hal/record/outcome.hpp"
#include "lab/runner.hpp"

namespace arkmesh::lab {

// Wall time of a run since its robots began to move.
struct WallTime {
  double computing_s = 0;
  double waiting_s = 0;
};

// What went between this lab and one peer.
struct Traffic {
  std::string version;  // of the peer's arkmesh; empty when the link said nothing
  std::uint64_t received_messages = 0, received_bytes = 0;
  std::map<std::string, std::uint64_t, std::less<>> counters;  // of the link: sent, dropped, refused, ...
};

// Version of this program and of what it was built with.
nlohmann::json program_facts();
// FNV-1a (64 bits) of what a file says, as hash_text; empty when it cannot be read.
std::string file_hash(const std::filesystem::path& file);
// What is known of a run when it begins, and what its result is made with. `programs`: the files of what simulated
// robots run.
nlohmann::json run_facts(const RunConfig& config, const std::string& effective_config,
                         const std::vector<std::filesystem::path>& programs);
// What came of the run; it is known before the lab has told everybody. One that was not recorded whole has failed.
hal::Outcome outcome_of(const Runner& run);
// Why it is no finished one; may be empty.
std::string end_of(const Runner& run);
// `facts` are those of the run.
nlohmann::json lab_result(nlohmann::json facts, const Runner& run, const WallTime& wall,
                          const std::map<std::string, Traffic>& between_labs);
// One result of labs that ran together: the shared part once, the rest by lab.
nlohmann::json joint_result(const std::vector<nlohmann::json>& labs);
// 16 hexadecimal digits.
std::string hash_text(std::uint64_t hash);

}  // namespace arkmesh::lab
