#include "emulator/emulator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim_ode/arena_groups.hpp"
#include "sim_ode/settings.hpp"
#include "tracker/detect/marker_finder.hpp"

namespace arkmesh::emulator {
namespace {

constexpr std::uint16_t no_id = 65'535;
constexpr std::size_t max_refused_noted = 100;

std::vector<std::uint16_t> make_ids(EmulatorConfig::Ids ids, int robots, std::uint64_t seed) {
  std::vector<std::uint16_t> out;
  for (int i = 0; i < robots; ++i)
    out.push_back(ids == EmulatorConfig::Ids::unassigned ? no_id : static_cast<std::uint16_t>(i));
  if (ids != EmulatorConfig::Ids::shuffled) return out;
  hal::RandomStream chance(seed, "room/ids");
  for (std::size_t k = out.size(); k > 1; --k) std::swap(out[k - 1], out[chance.below(k)]);
  return out;
}

}  // namespace

Emulator::Emulator(const hal::Section& root) : config_(read_emulator_config(root)), serial_(config_.seed) {
  const hal::Section arena = root.section("arena");
  const auto robots = arena.get("robots", 1, {.range = {0, 100'000}});
  sim_ode::SimulatedArenaOptions options;
  const sim_ode::Robot make = arena.section("ode").read<sim_ode::RobotKey>().robot;
  const bool by_marker = sim_ode::robots_of(make, hal::kilobot::ark_layout).seen_by == hal::RobotKind::Seen::marker;
  if (!by_marker) options = {.overhead = &serial_, .ids = make_ids(config_.ids, robots, config_.seed)};
  arena_ = sim_ode::make_simulated_arena(arena, "room", config_.seed, options);
  const hal::ArenaInfo& info = arena_->info();
  const hal::RobotKind& robot = info;  // whose height is not the arena's
  Scene& scene = config_.scene;
  scene.body_radius_m = info.body_radius_m;
  scene.robot_height_m = std::isnan(scene.stated_height_m) ? robot.height_m : scene.stated_height_m;
  if (by_marker) {
    scene.markers = info.robots;
    nodes_.emplace(*arena_);
    const int numbers = tracker::MarkerFinder::numbers(scene.marker_family);
    if (!info.robots.empty() && static_cast<int>(info.robots.back()) >= numbers)
      root.section("emulator")
          .section("scene")
          .refuse("markers", fmt::format("has the numbers 0 to {}, but robot {} has none of them", numbers - 1,
                                         info.robots.back()));
  }
  for (const CameraSettings& settings : config_.cameras) {
    try {
      eyes_.push_back({.camera = std::make_unique<Camera>(settings, config_.scene)});
    } catch (const std::invalid_argument& error) {
      root.section("emulator").refuse("camera", fmt::format("{} {}", settings.name, error.what()));
    }
  }
  // a wrong command is found now, not after an hour
  for (const EmulatorConfig::Event& event : config_.events)
    if (event.what.empty() || event.what.find('\n') != std::string::npos)
      root.section("emulator").refuse("event", "`do` must be one command");
  arena_->advance_to(hal::LabTime{0});
}

void Emulator::advance_to(hal::LabTime t) {
  for (;;) {
    hal::LabTime next = t;
    if (next_event_ < config_.events.size()) next = std::min(next, std::max(now(), config_.events[next_event_].at));
    for (const Lifted& lifted : lifted_) next = std::min(next, std::max(now(), lifted.until));
    if (nodes_) next = std::min(next, now() + AsebaNodes::poll_each);
    arena_->advance_to(next);
    if (nodes_) {
      std::vector<hal::Led> leds;
      for (const Truth& robot : truth()) leds.push_back(robot.led);
      nodes_->poll(leds);
    }
    put_down();
    while (next_event_ < config_.events.size() && config_.events[next_event_].at <= now()) {
      const EmulatorConfig::Event& event = config_.events[next_event_++];
      const std::string answer = command(event.what);
      if (answer.starts_with("error")) {
        if (counters_["emulator.events_refused"] < max_refused_noted)
          fmt::print(stderr, "arkmesh: event at {:.3f} s: {}\n", static_cast<double>(event.at.count()) * 1e-6, answer);
        counters_.add("emulator.events_refused");
      }
    }
    if (next == t) break;
  }
  std::erase_if(coverings_, [this](const Covering& covering) { return covering.until <= now(); });
}

// Where somebody else stands meanwhile, a hand puts a robot a little beside; where there is no room at all it waits.
void Emulator::put_down() {
  constexpr int places = 40;
  for (Lifted& lifted : lifted_) {
    if (lifted.until > now()) continue;
    bool stands = false;
    for (int k = 0; k < places && !stands; ++k) {
      const double far_m = 0.003 * k, angle = 2.4 * k;
      stands = arena_
                   ->put(lifted.robot, {lifted.to.x_m + far_m * std::cos(angle),
                                        lifted.to.y_m + far_m * std::sin(angle), lifted.to.heading_rad})
                   .empty();
    }
    seen_at_ = hal::LabTime{-1};
    lifted.robot = stands ? -1 : lifted.robot;
    lifted.until = now() + std::chrono::milliseconds(100);
  }
  std::erase_if(lifted_, [](const Lifted& lifted) { return lifted.robot < 0; });
}

bool Emulator::is_lifted(int robot) const {
  return std::ranges::any_of(lifted_, [robot](const Lifted& lifted) { return lifted.robot == robot; });
}

const std::vector<sim_ode::SimulatedArena::Seen>& Emulator::look() const {
  if (seen_at_ != now()) arena_->look(config_.exposure, seen_);
  seen_at_ = now();
  return seen_;
}

bool Emulator::picture(std::size_t number, cv::Mat& out) {
  Eye& eye = eyes_[number];
  if (eye.gone) return false;
  if (eye.frozen && !eye.last.empty()) {
    eye.last.copyTo(out);
    return true;
  }
  const auto noise = static_cast<std::uint64_t>(now().count());
  if (eye.dark) {
    eye.camera->dark_picture(noise, out);
  } else {
    std::vector<Hand> hands;
    for (const Covering& covering : coverings_) hands.push_back(covering.hand);
    eye.camera->picture(look(), hands, noise, out);
  }
  if (eye.frozen) out.copyTo(eye.last);
  return true;
}

std::vector<Emulator::Truth> Emulator::truth() const {
  std::vector<Truth> out;
  for (const sim_ode::SimulatedArena::Seen& seen : look()) {
    Truth& truth = out.emplace_back();
    truth.robot = static_cast<int>(out.size()) - 1;
    truth.id = arena_->id_of(truth.robot);
    // what shines for half of the exposure counts
    const float bright = 0.5F * std::max({seen.red, seen.green, seen.blue});
    const auto on = [bright](float part) { return part > 0.16F && part >= bright ? 1 : 0; };
    truth.led = static_cast<hal::Led>(on(seen.red) | on(seen.green) << 1 | on(seen.blue) << 2);
    truth.seen = seen;
  }
  return out;
}

hal::Counters Emulator::counters() const {
  hal::Counters out = counters_;
  for (const hal::Counters* part : {&serial_.counters(), &serial_.device().counters(), &arena_->counters()})
    for (const auto& [name, total] : part->all())
      if (!name.starts_with("poses.")) out.add(name, total);
  if (nodes_) out.merge(nodes_->counters());
  std::uint64_t pages = 0;
  for (int i = 0; i < robots(); ++i) pages += arena_->pages_written(i);
  out.set("robots.pages_written", pages);
  return out;
}

}  // namespace arkmesh::emulator
