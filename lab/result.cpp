#include "lab/result.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <gnu/libc-version.h>
#include <lcm/lcm.h>

#include <ctime>
#include <fstream>
#include <iterator>
#include <set>
#include <utility>

#include "hal/bus/loss.hpp"
#include "hal/record/result_file.hpp"

namespace arkmesh::lab {
namespace {

// FNV-1a.
std::uint64_t fingerprint(const std::string& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  return hash;
}

const char* reason_of(const hal::NotStanding& robot) {
  switch (robot.why) {
    case hal::NotStanding::Why::not_told:
      return "not told";
    case hal::NotStanding::Why::not_yet:
      return "not yet";
    case hal::NotStanding::Why::moving:
      return "moving";
    case hal::NotStanding::Why::not_in_sight:
      return "not in sight";
    case hal::NotStanding::Why::not_named:
      return "not named";
  }
  return "not told";
}

// Each lab's total as name@lab, and their sum as name; of one that all labs tell alike, only that.
nlohmann::json joint_counts(const std::vector<nlohmann::json>& labs) {
  nlohmann::json joint = nlohmann::json::object();
  for (const nlohmann::json& lab : labs) {
    const auto shared = lab.value("shared_counts", std::set<std::string>());
    for (const auto& [name, n] : lab.at("counts").items()) {
      joint[name] = n.get<std::uint64_t>() + (shared.contains(name) ? 0 : joint.value(name, std::uint64_t{0}));
      if (labs.size() > 1 && !shared.contains(name)) joint[name + "@" + lab.at("lab").get<std::string>()] = n;
    }
  }
  return joint;
}

nlohmann::json pauses_of(const RobotBook& run) {
  const auto seconds = [](hal::LabTime t) { return static_cast<double>(t.count()) / 1e6; };
  nlohmann::json out = nlohmann::json::array();
  for (const RobotBook::Pause& pause : run.pauses()) {
    nlohmann::json& told = out.emplace_back();
    told = {{"who", pause.who}, {"from_s", seconds(pause.from)}, {"until_s", nullptr}};
    if (pause.until) told["until_s"] = seconds(*pause.until);
  }
  return out;
}

}  // namespace

std::string hash_text(std::uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

std::string file_hash(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return in ? hash_text(fingerprint({std::istreambuf_iterator<char>(in), {}})) : std::string();
}

nlohmann::json program_facts() {
  nlohmann::json j;
  j["arkmesh"] = ARKMESH_VERSION;
  j["versions"] = {{"commit", ARKMESH_COMMIT},
                   {"build", ARKMESH_BUILD_TYPE},
                   {"compiler", __VERSION__},
                   {"glibc", gnu_get_libc_version()},
                   {"lcm", fmt::format("{}.{}.{}", LCM_MAJOR_VERSION, LCM_MINOR_VERSION, LCM_MICRO_VERSION)},
                   {"ode", ARKMESH_ODE_VERSION}};
#if defined(__x86_64__)
  j["cpu"] = {{"fma", __builtin_cpu_supports("fma") != 0}, {"avx2", __builtin_cpu_supports("avx2") != 0}};
#endif
  return j;
}

nlohmann::json run_facts(const RunConfig& config, const std::string& effective_config,
                         const std::vector<std::filesystem::path>& programs) {
  nlohmann::json j = program_facts();
  j["hashes"]["config.toml"] = hash_text(fingerprint(effective_config));
  for (const std::filesystem::path& file : programs)
    if (const std::string hash = file_hash(file), name = file.filename().string(); !hash.empty())
      if (!j["hashes"].contains(name)) j["hashes"][name] = hash;  // of files of one name the first
  j["started"] = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  j["process"] = hal::own_process();
  j["lab"] = config.lab;
  j["labs"] = config.labs;
  if (!config.absent.empty()) j["absent_labs"] = config.absent;
  j["scenario"] = config.scenario;
  j["seed"] = config.seed;
  return j;
}

hal::Outcome outcome_of(const Runner& run) {
  switch (run.outcome_code()) {
    case lab_status_t::finished:
      return run.recorder().recording() ? hal::Outcome::finished : hal::Outcome::failed;
    case lab_status_t::stopped:
      return hal::Outcome::stopped;
    case lab_status_t::failed:
      return hal::Outcome::failed;
    default:
      return hal::Outcome::running;
  }
}

std::string end_of(const Runner& run) {
  if (run.outcome_code() != lab_status_t::finished || run.recorder().recording()) return run.reason();
  return fmt::format("all periods were run, but log and tables are incomplete: the recording stopped ({})",
                     run.recorder().stopped_because());
}

nlohmann::json lab_result(nlohmann::json facts, const Runner& run, const WallTime& wall,
                          const std::map<std::string, Traffic>& between_labs) {
  const RunConfig& config = run.config();
  const double periods = std::max<double>(run.period(), 1), total_s = wall.computing_s + wall.waiting_s;
  const double lab_s = static_cast<double>((config.period * run.period()).count()) * 1e-6;
  nlohmann::json j = std::move(facts);
  j["gate"] = run.strict() ? "strict" : "free";
  hal::set_outcome(j, outcome_of(run), end_of(run));
  j["periods"] = run.period();
  j["duration_s"] = lab_s;
  j["final_hash"] = hash_text(run.final_hash());
  for (const auto& [lab, hash] : run.hash_by_lab()) j["hash_by_lab"][lab] = hash_text(hash);
  j["exchange"] = run.exchange_figures();
  j["counts"] = nlohmann::json::object();
  for (const auto& [name, n] : run.lab().counts().all()) j["counts"][name] = n;
  j["shared_counts"] = run.lab().shared_totals();
  for (const Shown& each : run.lab().shown())
    j["shown"].push_back({{"of", each.of}, {"words", each.words}, {"unit", each.unit}, {"curve", each.curve}});
  j["pauses"] = pauses_of(run.robot_book());
  j["not_standing"] = nlohmann::json::array();
  for (const hal::NotStanding& robot : run.not_standing())
    j["not_standing"].push_back({{"robot", robot.robot}, {"why", reason_of(robot)}});
  j["drops"] = nlohmann::json::object();
  j["counters"] = nlohmann::json::object();
  const hal::Counters counters = run.drops();
  j["notes"] = hal::loss_words(counters, "arena.");
  if (std::string words = hal::tracking_words(counters, "arena."); !words.empty())
    j["notes"].push_back(std::move(words));
  for (const auto& [name, n] : counters.all()) {
    j["counters"][name] = n;
    if (n > 0 && hal::is_loss(name)) j["drops"][name] = n;
  }
  j["wall"] = {
      {"total_s", total_s},
      {"computing_s", wall.computing_s},
      {"waiting_s", wall.waiting_s},
      {"per_period_ms", {{"computing", wall.computing_s * 1e3 / periods}, {"waiting", wall.waiting_s * 1e3 / periods}}},
      {"speed", total_s > 0 ? lab_s / total_s : 0}};
  j["peers"] = nlohmann::json::object();
  j["between_labs"] = nlohmann::json::object();
  for (const auto& [peer, traffic] : between_labs) {
    if (!traffic.version.empty()) j["peers"][peer]["version"] = traffic.version;
    nlohmann::json& t = j["between_labs"][peer] = {{"received_messages", traffic.received_messages},
                                                   {"received_bytes", traffic.received_bytes}};
    for (const auto& [name, n] : traffic.counters) t[name] = n;
  }
  return j;
}

nlohmann::json joint_result(const std::vector<nlohmann::json>& labs) {
  nlohmann::json joint;
  for (const char* key : {"arkmesh", "versions", "started", "process", "labs", "scenario", "seed", "gate", "periods",
                          "duration_s", "final_hash", "hash_by_lab"})
    joint[key] = labs.front().at(key);
  joint["counts"] = joint_counts(labs);
  for (const char* key : {"absent_labs", "shown"})
    if (const auto found = labs.front().find(key); found != labs.front().end()) joint[key] = *found;
  hal::set_outcome(joint, hal::outcome_in(labs.front()).value_or(hal::Outcome::failed), hal::ended_in(labs.front()));
  joint["drops"] = nlohmann::json::object();
  for (const nlohmann::json& lab : labs) {
    const std::string name = lab.at("lab");
    if (const auto outcome = hal::outcome_in(lab); outcome && outcome != hal::Outcome::finished)
      hal::set_outcome(joint, hal::outcome_in(joint) == hal::Outcome::failed ? hal::Outcome::failed : *outcome,
                       name + ": " + hal::ended_in(lab));
    for (const auto& [what, n] : lab.at("drops").items()) joint["drops"][name + "." + what] = n;
    for (const char* key :
         {"counts", "pauses", "not_standing", "counters", "exchange", "wall", "peers", "between_labs"})
      joint["by_lab"][name][key] = lab.at(key);
    joint["by_lab"][name]["notes"] = lab.value("notes", nlohmann::json::array());
  }
  return joint;
}

}  // namespace arkmesh::lab
