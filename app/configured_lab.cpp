#include "app/configured_lab.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <iterator>
#include <random>
#include <set>
#include <utility>

#include "app/arenas.hpp"
#include "app/robot_limits.hpp"
#include "app/scenarios.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/config/near_key.hpp"
#include "hal/files/replace_file.hpp"
#include "hal/files/whole_file.hpp"
#include "hal/time/loop_time.hpp"
#include "lab/operator/operator_message.hpp"
#include "lab/result.hpp"

namespace arkmesh::app {
namespace {

constexpr std::uintmax_t max_kept_bytes = 16 << 20;  // of a file; recordings that are played are larger
constexpr std::chrono::milliseconds flush_each{50};  // where labs share a process

const CatalogueEntry& chosen_scenario(const hal::Section& root, const lab::RunConfig& run) {
  std::string known;
  std::set<std::string, std::less<>> names;
  const CatalogueEntry* chosen = nullptr;
  for (const CatalogueEntry& entry : catalogue()) {
    if (entry.name == run.scenario)
      chosen = &entry;
    else
      root.section("scenario").leave_alone(entry.name);
    names.insert(entry.name);
    known += (known.empty() ? "" : ", ") + entry.name;
  }
  if (chosen) return *chosen;
  const auto near = hal::near_key(run.scenario, names);
  root.section("run").refuse(
      "scenario", fmt::format("is none of: {}{}", known, near ? fmt::format("; did you mean {}?", *near) : ""));
}

// 64 random bits, never 0.
std::uint64_t random_run_id() {
  std::random_device device;
  const std::uint64_t run_id = static_cast<std::uint64_t>(device()) << 32 | device();
  return run_id == 0 ? 1 : run_id;
}

}  // namespace

ConfiguredLab::ConfiguredLab(hal::Config config, std::filesystem::path directory, hal::EventLoop& loop, OwnParts* own)
    : loop_(loop),
      config_(std::move(config)),
      directory_(std::move(directory)),
      run_config_(config_.root().read<lab::RunConfig>()),
      run_id_(random_run_id()),
      signatures_(config_.root().section("gateway").get("keys", std::filesystem::path())),
      private_bus_("memq://") {
  const hal::Section root = config_.root();
  bus_config_ = root.section("bus").read<hal::BusConfig>();
  view_config_ = root.section("view").read<view::ViewConfig>();
  gateway_config_ = gateway::read_gateway_config(root.section("gateway"), run_config_.lab, run_config_.labs);
  run_config_.max_message_bytes =
      std::min<std::size_t>(run_config_.max_message_bytes, gateway_config_.max_message_bytes);
  recorder_config_ = root.section("recorder").read<lab::RecorderConfig>();
  make_parts(own);
}

void ConfiguredLab::make_parts(OwnParts* own) {
  const hal::Section root = config_.root();
  const bool in_python = scenarios::python::is_python(run_config_.scenario);
  // whom it speaks to shows when it does; what no id fits is counted
  const CatalogueEntry python{.name = run_config_.scenario, .make = nullptr, .addresses_robots = false};
  const CatalogueEntry& scenario = in_python && !own ? python : chosen_scenario(root, run_config_);
  own_parts_ = own != nullptr;
  if (own) {
    OwnParts::Made made = own->make(config_, run_config_, loop_);
    config_.refuse_unknown();
    arena_ = std::move(made.arena);
    scenario_ = std::move(made.scenario);
    return;
  }
  // A scenario in Python is told of its arena, and then asks for its settings.
  const std::string table = std::filesystem::path(run_config_.scenario).stem().string();
  if (in_python) {
    scenarios::python::answer_time(root.section("scenario"));
    for (const char* of : {"scenario", "sensors"}) root.section(of).leave_alone(table);
  } else {
    scenario_ = scenario.make(root.section("scenario").section(run_config_.scenario), run_config_.labs);
  }
  arena_ = make_arena(config_, run_config_, private_bus_, pictures_, directory_);
  if (in_python) {
    for (const char* of : {"scenario", "sensors"}) root.section(of).take_up(table);
    auto made = std::make_unique<scenarios::python::PythonScenario>(root, config_.file(), run_config_, arena_->info(),
                                                                    words_per_s(root.section("arena")), directory_);
    if (made->failure().empty())  // else it has not asked for all
      for (const char* of : {"scenario.", "sensors."}) config_.refuse_unknown(of + table);
    python_ = made.get();
    scenario_ = std::move(made);
  }
  check_robot_limits(root, run_config_, scenario, arena_->info(), settings());
}

// What all labs must have alike.
std::map<std::string, std::string, std::less<>> ConfiguredLab::settings() const {
  auto all = lab::shared_settings(config_);
  if (python_) all.merge(python_->shared_settings());
  return all;
}

std::vector<std::filesystem::path> ConfiguredLab::robots_programs() const {
  if (own_parts_) return {};
  return robots_programs_of(config_.root().section("arena"));
}

// Files of the user's that the run was made with, and folders that hold such, by their places in `files` of the run's
// folder. They lie there as they lay beside each other.
hal::Config::Kept ConfiguredLab::kept_files() const {
  std::set<std::filesystem::path> files;
  for (const std::filesystem::path& file : robots_programs()) files.insert(file);
  const std::vector<std::filesystem::path> named = config_.paths();
  for (const std::filesystem::path& file : named)
    if (std::error_code error; std::filesystem::file_size(file, error) <= max_kept_bytes && file.extension() != ".lcm")
      files.insert(file);
  if (files.empty()) return {};
  std::filesystem::path above = files.begin()->parent_path();
  const auto is_below = [](const std::filesystem::path& path, const std::filesystem::path& folder) {
    const std::filesystem::path way = path.lexically_relative(folder);
    return !way.empty() && *way.begin() != "..";
  };
  hal::Config::Kept kept;
  for (const std::filesystem::path& path : named)
    if (std::ranges::any_of(files, [&](const auto& file) { return is_below(file, path); })) kept[path];
  for (const std::filesystem::path& file : files) kept[file];
  for (const auto& [path, copy] : kept)
    while (!is_below(path.parent_path(), above)) above = above.parent_path();
  for (auto& [path, copy] : kept) copy = "files" / path.lexically_relative(above);
  return kept;
}

void ConfiguredLab::open_run(std::shared_ptr<lab::WorldReader> worlds) {
  const hal::Config::Kept kept = kept_files();
  const std::string effective = config_.effective(directory_, kept);
  facts_ = lab::run_facts(run_config_, effective, robots_programs());
  facts_["files"] = config_.files();
  facts_["arena"] = {{"platform", arena_->info().platform}};
  if (const std::string& platform = arena_->info().platform; platform.starts_with("ode"))
    facts_["arena"]["infrared"] = platform.find("argos") == std::string::npos ? "robot" : "argos";
  if (python_) facts_["scenario_in_python"] = python_->facts();
  hal::Recorder::Options record = recorder_config_.options();
  if (worlds) record.flush_each = flush_each;
  folder_ = std::make_unique<lab::RunFolder>(directory_, effective, record, facts_);
  for (const auto& [file, copy] : kept)
    if (const auto bytes = hal::whole_file(file, max_kept_bytes)) {
      std::filesystem::create_directories((directory_ / copy).parent_path());
      hal::must_replace_file(directory_ / copy, *bytes);
    }
  if (python_) python_->keep_sources();
  runner_ =
      std::make_unique<lab::Runner>(run_config_, settings(), *arena_, *scenario_, private_bus_, folder_->recorder(),
                                    run_id_, worlds ? std::move(worlds) : std::make_shared<lab::WorldReader>());
  runner_->ask(std::bind_front(&TrustedSignatures::has_signed, &signatures_));
}

std::vector<std::filesystem::path> ConfiguredLab::inputs() const {
  std::vector<std::filesystem::path> out;
  for (const std::string& name : config_.files()) out.push_back(config_.file().parent_path() / name);
  std::ranges::move(robots_programs(), std::back_inserter(out));
  return out;
}

// Robots do not go on when a run ends by an exception.
ConfiguredLab::~ConfiguredLab() {
  try {
    if (runner_) runner_->fail("the lab was ended");
    hal::LoopTime time(loop_);
    hal::end(*arena_, time);
  } catch (const std::exception&) {
    // the arena is lost
  }
}

ConfiguredLab::Membership::Membership(ConfiguredLab& lab, hal::Bus& public_bus)
    : runner_(*lab.runner_),
      commands_(public_bus.subscribe("([^/]+/)?" + lab::operator_channel, [&lab](std::string_view channel, auto bytes) {
        lab.runner_->hear_command(channel, bytes);
      })) {
  if (&public_bus == &lab.private_bus_) return;
  tap_.emplace(lab.private_bus_, public_bus,
               std::vector<std::string>{"[^/]+/world", "[^/]+/status", hal::channel::peers});
  runner_.count(&public_bus);
}

}  // namespace arkmesh::app
