// Puts the parts together in time order: robot ticks at n x 32.768 ms, composites at n x composite_s, frames at
// n x frame_period; at equal times in this order. Nothing here depends on how calls of advance_to slice the time.
#include "sim_ode/ode_arena.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "hal/arenas/arena_config.hpp"
#include "hal/arenas/newest_frame.hpp"
#include "hal/counted.hpp"
#include "hal/fixed_math.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "hal/platforms/kilobot/message_registers.hpp"
#include "hal/robot/thymio.hpp"
#include "hal/time/pacer.hpp"
#include "sim_ode/arena_groups.hpp"
#include "sim_ode/contact_world.hpp"
#include "sim_ode/host/battery.hpp"
#include "sim_ode/host/led_lights.hpp"
#include "sim_ode/host/motors.hpp"
#include "sim_ode/host/programs/program_inputs.hpp"
#include "sim_ode/host/robot_groups.hpp"
#include "sim_ode/hostile_air.hpp"
#include "sim_ode/infrared_exchange.hpp"
#include "sim_ode/infrared_medium.hpp"
#include "sim_ode/light_field.hpp"
#include "sim_ode/overhead_air.hpp"
#include "sim_ode/proximity.hpp"
#include "sim_ode/settings.hpp"
#include "sim_ode/simulated_arena.hpp"
#include "sim_ode/start_places.hpp"

namespace arkmesh::sim_ode {
namespace {

class OdeArena final : public SimulatedArena {
 public:
  OdeArena(const hal::ArenaConfig& config, const hal::kilobot::WordLayout& layout, const Settings& settings,
           const hal::Solids& solids, std::vector<RobotGroups::Group> groups, const std::vector<hal::Pose>& start,
           std::vector<RobotProfile> profiles, const std::string& lab, std::uint64_t seed,
           const SimulatedArenaOptions& options)
      : settings_(settings),
        info_(info_of(config, settings, layout, solids, lab)),
        poses_(counters_),
        registers_(info_, counters_),
        motors_(settings, std::move(profiles), lab, seed),
        leds_(config.robots),
        batteries_(settings, motors_.profiles()),
        world_(config.width_m, config.height_m, settings.contacts, seed, start, solids),
        light_(settings, config.robots, lab, seed),
        proximity_(world_, config.width_m, config.height_m, info_.body_radius_m, info_.drive.axle_behind_m),
        host_(std::move(groups), motors_, leds_, sensors(options.overhead != nullptr), lab, seed, options.ids,
              output_of(options)),
        infrared_(make_infrared(settings, config.width_m, config.height_m, motors_.profiles(), lab, seed,
                                world_.solids().empty() ? nullptr : &shadows_, options.overhead)),
        overhead_(settings_, info_, world_, *infrared_, options.overhead, lab, seed, counters_) {
    if (options.hostile) hostile_.emplace(seed, lab);
    if (!info_.can_wait) pacer_.emplace(config.frame_period, counters_);
    host_.visit([&](RobotHost& host) {
      if (settings.leave_failed) host.leave_failed_robots();
      if (overhead_.is_outside()) host.nothing_is_repeated();
      host.hear_overhead_at(settings.air.overhead_distance_m);
    });
    if (!world_.solids().empty()) {
      world_.solids().shade(shadows_);
      light_.set_blockers(&shadows_);
    }
  }

  const hal::ArenaInfo& info() const override { return info_; }
  const hal::Clock& clock() const override { return clock_; }
  hal::PoseSource& poses() override { return poses_; }
  hal::RobotLink& robots() override { return registers_; }

  bool advance_to(hal::LabTime t) override {
    assert(t >= clock_.now() && "lab time never decreases");
    if (pacer_ && t > clock_.now() && !pacer_->reached(t)) return false;
    if (!lost_.empty()) throw std::runtime_error(lost_);
    std::optional<FaultGuard::Watch> watch;
    for (;;) {
      const hal::LabTime tick{ticks_ * tick_us + tick_us}, composite = (composites_ + 1) * settings_.composite,
                                                           frame = frames_ * info_.frame_period;
      const hal::LabTime next = std::min({tick, composite, frame});
      if (next > t) break;
      clock_.set(next);
      if (tick == next) {
        if (!watch) watch.emplace(host_.guard());
        run_tick();
      } else if (composite == next) {
        send_composite();
      } else {
        make_frame();
      }
    }
    clock_.set(t);
    if (overhead_.is_outside()) show_what_was_heard(overhead_.sent_until(t));
    return true;
  }
  void serve() override {}
  hal::TimePoint next_service() const override { return pacer_ ? pacer_->next() : hal::TimePoint::max(); }
  std::string waiting_for() const override { return {}; }
  bool end() override {
    if (!info_.can_be_driven()) host_.visit([](const RobotHost& host) { host.tell_at_end(); });
    return true;
  }
  std::vector<hal::NotStanding> not_standing() const override { return {}; }

  void look(hal::LabTime exposure, std::vector<Seen>& out) const override {
    const std::int64_t since_us = clock_.now().count() - ticks_ * tick_us;
    // the pose is that in the exposure's middle
    const std::int64_t half_us = exposure.count() / 2;
    (early_leds_ ? *early_leds_ : leds_)
        .gather(std::max<std::int64_t>(0, since_us - half_us), std::min<std::int64_t>(tick_us, since_us + half_us),
                light_of_);
    out.resize(info_.robots.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
      const auto robot = static_cast<int>(i);
      out[i].pose = world_.pose(robot, static_cast<double>(since_us) / tick_us);
      const hal::Pose next = world_.pose(robot, static_cast<double>(since_us + tick_us) / tick_us);
      const double share = static_cast<double>(exposure.count()) / tick_us;
      out[i].moved = {share * (next.x_m - out[i].pose.x_m), share * (next.y_m - out[i].pose.y_m),
                      share * std::remainder(next.heading_rad - out[i].pose.heading_rad, 2 * std::numbers::pi)};
      out[i].red = light_of_[i][0] / 3;
      out[i].green = light_of_[i][1] / 3;
      out[i].blue = light_of_[i][2] / 3;
      out[i].in_arena = world_.in_arena(robot);
      out[i].powered = host_.powered(robot);
      out[i].led_bearing_rad = motors_.profiles()[i].led_bearing_rad;
    }
  }

  void take_off(int robot) override {
    if (!world_.in_arena(robot)) return;
    world_.take_off(robot);
    overhead_.take_off();
  }

  std::string put(int robot, const hal::Pose& pose) override {
    for (int i = 0; i < world_.robots(); ++i)
      if (i != robot && world_.in_arena(i)) {
        const hal::Pose other = world_.pose(i, 1);
        if (hal::fixed::hypot(other.x_m - pose.x_m, other.y_m - pose.y_m) < 2 * info_.body_radius_m)
          return fmt::format("there is no room for robot {} at {:.3f}, {:.3f}: robot {} stands there", robot, pose.x_m,
                             pose.y_m, i);
      }
    if (!std::isfinite(pose.heading_rad) ||
        !error_with({pose}, info_.width_m, info_.height_m, world_.solids()).empty() ||
        !std::isfinite(pose.x_m + pose.y_m))
      return fmt::format("{}, {} is not completely inside the walls and clear of obstacles and objects", pose.x_m,
                         pose.y_m);
    if (!world_.in_arena(robot)) overhead_.put_back();
    world_.place(robot, pose);
    return {};
  }

  void set_power(int robot, bool on) override { host_.set_power(robot, on); }
  std::uint16_t id_of(int robot) const override { return host_.id_of(robot); }
  std::optional<std::int16_t> prox(int robot, int sensor) const override { return proximity_.reading(robot, sensor); }
  std::uint64_t pages_written(int robot) const override { return host_.loader(robot).pages_written(); }

  const hal::Counters& counters() const override {
    const InfraredMedium::Totals& air = infrared_->totals();
    const ContactWorld::Totals& world = world_.totals();
    counters_.set("infrared.sent", air.sent);
    counters_.set("infrared.received", air.received);
    counters_.set("infrared.refused.crc", air.bad_crc);
    counters_.set("infrared.refused.type", air.for_firmware);
    const DeafPairs::Totals pairs = infrared_->pairs();
    counters_.set("infrared.pairs.in_reach", pairs.in_reach);
    counters_.set("infrared.pairs.deaf", pairs.deaf);
    counters_.set("infrared.lost.spoiled", air.spoiled);
    counters_.set("infrared.lost.chance", air.lost);
    if (air.crowded > 0) counters_.set("infrared.lost.crowded", air.crowded);
    counters_.set("infrared.backed_off", air.backed_off);
    if (host_.failed_robots() > 0) counters_.set("robots.failed", host_.failed_robots());
    if (host_.waited_robots() > 0) counters_.set("robots.waited", host_.waited_robots());
    if (host_.heap_misuse() > 0) counters_.set("robots.heap_misuse", host_.heap_misuse());
    counters_.set("contacts.robot_ticks", world.touching);
    counters_.set("contacts.solved", world.contacts);
    counters_.set("contacts.by_ode", world.by_ode);
    counters_.set("contacts.alone", world.alone);
    counters_.set("contacts.ode_steps", world.ode_steps);
    counters_.set("contacts.deeper_than_1mm", world.deep);
    return counters_;
  }

 private:
  RobotOutput output_of(const SimulatedArenaOptions& options) const {
    RobotOutput out = options.output;
    for (const hal::RobotId id : info_.robots) out.names.push_back(std::to_string(id));
    return out;
  }

  // `outside`: the overhead controller is, which hears nobody.
  RobotSensors sensors(bool outside) {
    std::function<void(int, std::uint8_t, std::int32_t)> say;
    if (!outside)
      say = [this](int robot, std::uint8_t kind, std::int32_t value) {
        registers_.hear({info_.robots[static_cast<std::size_t>(robot)], kind, value});
      };
    std::function<double(int)> voltage;
    if (batteries_.run_down()) voltage = [this](int robot) { return batteries_.voltage(robot); };
    return {.light =
                [this](int robot) {
                  const auto i = static_cast<std::size_t>(robot);
                  return light_.reading(robot, world_.x()[i], world_.y()[i], world_.heading(robot));
                },
            .receiving = [this](int robot, std::int64_t at_us) { return infrared_->receiving(robot, at_us); },
            .voltage = std::move(voltage),
            .say = std::move(say),
            .prox = settings_.robot == Robot::thymio ? [this](int robot, int sensor) { return prox(robot, sensor); }
                                                     : decltype(RobotSensors::prox)(),
            .by_argos = settings_.infrared == InfraredRules::argos};
  }

  // Robots' turns, then their messages, then the motion up to the next tick: frames in between show part of that
  // motion.
  void run_tick() {
    ++ticks_;
    try {
      leds_.end_tick();
      if (batteries_.run_down()) drain_batteries();
      if (overhead_.is_outside()) overhead_.hear(clock_.now(), inbox_.overhead);
      host_.tick(ticks_, inbox_);
      inbox_.overhead.clear();
      exchange_infrared(ticks_, world_, host_, *infrared_, inbox_.infrared);
      if (hostile_) hostile_->add(world_.robots(), inbox_.infrared);
    } catch (const ProgramFault& fault) {
      lost_ = fault.what();
      throw;
    }
    for (const Motors::Change& change : motors_.end_tick()) world_.set_velocity(change.robot, change.velocity);
    world_.tick();
    if (world_.solids().any_moves()) world_.solids().shade(shadows_);
  }

  // Some robots each tick, all once a second. An empty battery switches its robot off.
  void drain_batteries() {
    for (int robot = Batteries::first(ticks_); robot < world_.robots(); robot += Batteries::looks_every) {
      if (!host_.powered(robot)) continue;
      batteries_.spend(robot, motors_.load_us(robot), leds_.steps_us(robot));
      motors_.weaken(robot, batteries_.voltage(robot));
      if (!batteries_.empty(robot)) continue;
      host_.set_power(robot, false);
      counters_.add("robots.battery_empty");
    }
  }

  // Robots' turns come at ticks; the LED of a robot obeys a command at once.
  void show_what_was_heard(std::span<const Transmission> sent) {
    early_leds_.reset();
    for (const Transmission& one : sent) {
      if (!one.clean || one.message.type <= 127) continue;
      if (!early_leds_) early_leds_ = leds_;
      for (int robot = 0; robot < world_.robots(); ++robot) {
        const auto colour = world_.in_arena(robot) ? host_.shown_after(robot, one.message.type) : std::nullopt;
        if (colour) early_leds_->set(robot, *colour, std::max<std::int64_t>(1, one.end_us - ticks_ * tick_us));
      }
    }
  }

  void send_composite() {
    ++composites_;
    if (overhead_.is_outside()) return;
    for (const auto& [robot, wheels] :
         overhead_.send_composite(clock_.now(), ticks_ * tick_us, registers_, inbox_.overhead))
      motors_.drive(static_cast<int>(std::ranges::lower_bound(info_.robots, robot) - info_.robots.begin()), wheels);
  }

  void make_frame() {
    hal::PoseFrame frame;
    frame.stamp = clock_.now();
    frame.number = static_cast<std::uint32_t>(frames_++);
    // before the first tick robots stand; after it the last step leads from the latest tick to the next one
    const std::int64_t since_us = clock_.now().count() - ticks_ * tick_us;
    const double share = static_cast<double>(since_us) / tick_us;
    if (!settings_.blank_leds) leds_.look(since_us, seen_);
    frame.robots.resize(info_.robots.size());
    for (std::size_t i = 0; i < info_.robots.size(); ++i) {
      hal::Observation& observation = frame.robots[i];
      observation.robot = info_.robots[i];
      observation.pose = world_.pose(static_cast<int>(i), share);
      if (!settings_.blank_leds) observation.led = seen_[i];
    }
    world_.solids().poses(share, frame.objects);
    poses_.put(std::move(frame));
  }

  Settings settings_;
  mutable hal::Counters counters_;  // some are brought up to date when somebody looks
  hal::ArenaInfo info_;
  hal::OwnedClock clock_;
  hal::NewestFrame poses_;
  hal::kilobot::MessageRegisters registers_;
  Motors motors_;
  LedLights leds_;
  std::optional<LedLights> early_leds_;  // with what the robots will show for what they have heard since the tick
  Batteries batteries_;
  ContactWorld world_;
  Shadows shadows_;  // of obstacles and objects
  LightField light_;
  Proximity proximity_;
  RobotGroups host_;
  std::unique_ptr<InfraredMedium> infrared_;
  OverheadAir overhead_;
  std::optional<HostileAir> hostile_;
  mutable std::vector<std::array<float, 3>> light_of_;
  std::optional<hal::Pacer> pacer_;  // none: can wait
  Inbox inbox_;                      // for the next tick
  std::vector<hal::Led> seen_;
  std::int64_t ticks_ = 0, composites_ = 0, frames_ = 0;  // so far; frames also the next one's number
  std::string lost_;                                      // why the arena is lost for good
};

std::unique_ptr<OdeArena> make(
    const hal::Section& arena, const std::string& lab, std::uint64_t seed, const SimulatedArenaOptions& given,
    const std::filesystem::path& program = {}, const std::function<void()>& all_read = [] {}) {
  const hal::kilobot::WordLayout layout = hal::kilobot::read_layout(arena);
  const double body_radius_m = robots_of(arena.section("ode").read<RobotKey>().robot, layout).body_radius_m;
  const hal::ArenaConfig config = hal::read_arena_config(arena, body_radius_m);
  const hal::Solids solids = hal::read_solids(arena);
  const SolidBodies furniture(config.width_m, config.height_m, solids, body_radius_m);
  if (const std::string wrong = furniture.misplaced(); !wrong.empty()) arena.refuse("objects", wrong);
  Settings settings = read_settings(arena, program);
  const hal::Section ode = arena.section("ode");
  if (given.overhead && settings.infrared == InfraredRules::argos)
    ode.refuse("infrared", "must be \"robot\" for emulated robots, whose controller sends light; remove it");
  if (!program.empty() && settings.robot != Robot::kilobot)
    ode.refuse("robot", "must be \"kilobot\" here: this procedure sets up Kilobots");
  SimulatedArenaOptions options = given;
  std::vector<GroupSettings> groups = groups_of(ode, settings, config.robots);
  number_robots(ode, settings, groups, options.ids);
  const std::vector<hal::Pose> start = start_of(config, groups, ode, furniture, lab, seed);

  std::vector<RobotProfile> profiles = profiles_of(settings, arena.section("ode"), config.robots, lab, seed);
  all_read();
  try {
    std::vector<RobotGroups::Group> programs;
    for (const GroupSettings& group : groups)
      programs.push_back({RobotProgram::load(group.controller), group.robots, group.loops_per_tick});
    return std::make_unique<OdeArena>(config, layout, settings, solids, std::move(programs), start, std::move(profiles),
                                      lab, seed, options);
  } catch (const ProgramError& error) {
    arena.section("ode").refuse("controller", error.what());
  } catch (const ProgramFault& fault) {
    if (options.output.text) throw ProgramError(fault.what());
    arena.section("ode").refuse("controller", fault.what());
  }
}

}  // namespace

hal::ArenaRow ode_arena_row(std::function<TurnLog*(const std::string& lab)> log) {
  return {"ode",
          {"ode"},
          hal::ArenaRow::Robots::simulated,
          [log = std::move(log)](const hal::Section& arena, const hal::ArenaRequest& request) {
            const std::filesystem::path program =
                request.program.empty() ? std::filesystem::path() : firmware_folder() / request.program;
            return std::unique_ptr<hal::Arena>(make(
                arena, request.lab, request.seed,
                {.output = {.log = log ? log(request.lab) : nullptr,
                            .folder = request.directory.empty() ? request.directory : request.directory / "robots"}},
                program, request.all_read));
          },
          [] {
            std::vector<hal::KeyRow> rows = hal::keys_of<ViewSettings>("arena");
            std::ranges::move(hal::keys_of<Settings>("arena.ode"), std::back_inserter(rows));
            return rows;
          },
          [](const hal::Section& arena) { return arena.section("ode").read<Settings>().composite; },
          program_files};
}

std::unique_ptr<hal::Arena> make_ode_arena(const hal::Section& arena, const std::string& lab, std::uint64_t seed,
                                           const RobotOutput& output, bool hostile) {
  return make(arena, lab, seed, {.output = output, .hostile = hostile});
}

std::unique_ptr<SimulatedArena> make_simulated_arena(const hal::Section& arena, const std::string& lab,
                                                     std::uint64_t seed, const SimulatedArenaOptions& options) {
  if (arena.get("pace", 0.0) != 0) arena.refuse("pace", "must be 0: the emulated hardware keeps time");
  return make(arena, lab, seed, options);
}

}  // namespace arkmesh::sim_ode
