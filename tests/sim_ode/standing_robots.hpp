// Standing robots that send, heard one by one.
#pragma once

#include <vector>

#include "sim_ode/contact_world.hpp"
#include "sim_ode/host/robot_host.hpp"
#include "sim_ode/infrared_exchange.hpp"
#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {

// Standing robots that all send all the time, with every part within reach.
struct Standing {
  Standing(const std::vector<hal::Pose>& places, Settings with = {}, std::uint64_t seed = 1,
           const char* program = "chatter.c", const Shadows* shapes = nullptr)
      : settings(with),
        motors(settings, static_cast<int>(places.size()), "shark", seed),
        leds(static_cast<int>(places.size())),
        world(2, 2, {}, seed, places),
        host(RobotProgram::load(controller(program)), static_cast<int>(places.size()), motors, leds,
             {.by_argos = with.infrared == InfraredRules::argos}, "shark", seed),
        made(make_infrared(settings, 2, 2, motors.profiles(), "shark", seed, shapes)),
        medium(*made),
        heard_by(places.size() * places.size()) {
    Message run;
    run.type = type_run;
    inbox.overhead.push_back({0, run, {}});
  }
  void step() {
    host.tick(++tick, inbox);
    inbox.overhead.clear();
    exchange_infrared(tick, world, host, medium, inbox.infrared);
    for (const Reception& reception : inbox.infrared)
      if (reception.message.data[0] < leds_count())  // programs that begin with their id
        ++heard_by[static_cast<std::size_t>(reception.robot) * leds_count() + reception.message.data[0]];
  }
  std::size_t leds_count() const { return world.x().size(); }
  // Messages of `sender` that `listener` has heard.
  int heard(std::size_t listener, std::size_t sender) const { return heard_by[listener * leds_count() + sender]; }

  Settings settings;
  Motors motors;
  LedLights leds;
  ContactWorld world;
  RobotHost host;
  std::unique_ptr<InfraredMedium> made;
  InfraredMedium& medium;
  Inbox inbox;
  std::vector<int> heard_by;
  std::int64_t tick = 0;
};

}  // namespace arkmesh::sim_ode
