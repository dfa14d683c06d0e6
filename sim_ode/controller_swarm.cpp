#include "sim_ode/controller_swarm.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <numbers>

#include "hal/random.hpp"
#include "sim_ode/ode_arena.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr const char* lab = "swarm";

// A square grid round the arena's centre, filled from its lower left corner; headings at random.
std::vector<hal::Pose> grid_places(const SwarmOptions& options) {
  const int columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(options.robots))));
  const int rows = (options.robots + columns - 1) / columns;
  hal::RandomStream headings(options.seed, std::string(lab) + "/grid");
  std::vector<hal::Pose> places;
  for (int i = 0; i < options.robots; ++i)
    places.push_back({.x_m = (i % columns - (columns - 1) / 2.0) * options.spacing_m,
                      .y_m = (i / columns - (rows - 1) / 2.0) * options.spacing_m,
                      .heading_rad = headings.uniform() * 2 * std::numbers::pi - std::numbers::pi});
  return places;
}

hal::Config arena_config(const SwarmOptions& options) {
  const auto list = [](const auto& texts, const auto& to_text) {
    std::vector<std::string> out;
    for (const auto& text : texts) out.push_back(hal::to_toml(to_text(text)));
    return fmt::format("[{}]", fmt::join(out, ", "));
  };
  const auto path = [](const std::filesystem::path& given) { return std::filesystem::absolute(given).string(); };
  const auto same = [](const std::string& given) { return given; };
  std::string text = fmt::format(
      "[arena]\nrobots = {}\nwidth_m = {}\nheight_m = {}\n[arena.ode]\ncontroller = {}\ninclude = {}\ndefine = {}\n",
      options.robots, hal::to_toml(options.width_m), hal::to_toml(options.height_m), list(options.program.paths, path),
      list(options.program.include, path), list(options.program.define, same));
  const std::vector<hal::Pose> places =
      options.places.empty() && options.spacing_m > 0 ? grid_places(options) : options.places;
  if (!places.empty()) {
    std::vector<std::string> numbers;
    for (const hal::Pose& place : places)
      for (const double number : {place.x_m, place.y_m, place.heading_rad}) numbers.push_back(hal::to_toml(number));
    text += fmt::format("start_poses = [{}]\n", fmt::join(numbers, ", "));
  }
  if (options.light)
    text += fmt::format("lamp = [{}, {}]\n", hal::to_toml(options.light->x_m), hal::to_toml(options.light->y_m));
  std::vector<std::string> overrides;
  for (const std::string& setting : options.settings) overrides.push_back("arena." + setting);
  return hal::Config::from_text(text, "controller run", overrides);
}

}  // namespace

ControllerSwarm::ControllerSwarm(const SwarmOptions& options) : program_(sim_ode::RobotProgram::load(options.program)) {
  const hal::Config config = arena_config(options);
  try {
    arena_ =
        sim_ode::make_ode_arena(config.root().section("arena"), lab, options.seed,
                                {.text = &text_, .log = options.log, .folder = options.robots_folder}, options.hostile);
  } catch (const hal::ConfigError& error) {
    const std::string sentence = error.what();
    // of a grid nobody wants to see all the places
    if (const auto poses = sentence.find("start_poses = ["),
        end = sentence.find(": ", std::min(poses, sentence.size()));
        options.spacing_m > 0 && end != std::string::npos)
      throw hal::ConfigError(fmt::format("--spacing {}: {}; give a larger arena, fewer robots or another spacing",
                                         options.spacing_m, sentence.substr(end + 2)));
    throw;
  }
  config.refuse_unknown();
  hal::advance(*arena_, hal::LabTime(0));
  arena_->robots().command({.kind = hal::FleetCommand::Kind::run});
}

void ControllerSwarm::run_until(hal::LabTime end, const std::function<void(const hal::PoseFrame&)>& look) {
  for (; next_ <= end; next_ += arena_->info().frame_period) {
    hal::advance(*arena_, next_);
    while (const std::optional<hal::PoseFrame> frame = arena_->poses().latest()) look(*frame);
  }
}

}  // namespace arkmesh::sim_ode
