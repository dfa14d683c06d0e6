// Friction 0.3, QuickStep with its 20 iterations, one contact per pair.
#include "tests/bench/textbook_swarm.hpp"

#include <ode/ode.h>

#include <cmath>
#include <vector>

#include "hal/platforms/kilobot/body.hpp"
#include "hal/random.hpp"
#include "sim_ode/start_places.hpp"

namespace arkmesh::bench {

struct TextbookSwarm::State {
  dWorldID world;
  dSpaceID space;
  dJointGroupID contacts;
  std::vector<dBodyID> bodies;
  std::vector<dJointID> planes;
  std::vector<int> until;
  std::vector<double> speed, turn;
  hal::RandomStream chance{1, "bench/textbook"};
  int number = 0;

  static void touch(void* data, dGeomID a, dGeomID b) {
    auto& self = *static_cast<State*>(data);
    dContact contact{};
    if (dCollide(a, b, 1, &contact.geom, sizeof contact) == 0) return;
    contact.surface.mode = dContactApprox1;
    contact.surface.mu = 0.3;
    dJointAttach(dJointCreateContact(self.world, self.contacts, &contact), dGeomGetBody(a), dGeomGetBody(b));
  }
};

TextbookSwarm::TextbookSwarm(int robots, double side_m) : state_(std::make_unique<State>()) {
  dInitODE2(0);
  State& w = *state_;
  w.world = dWorldCreate();
  w.space = dHashSpaceCreate(nullptr);
  w.contacts = dJointGroupCreate(0);
  dWorldSetAutoDisableFlag(w.world, 0);
  const double half = side_m / 2, r = hal::kilobot::body_radius_m;
  dCreatePlane(w.space, 1, 0, 0, -half);
  dCreatePlane(w.space, -1, 0, 0, -half);
  dCreatePlane(w.space, 0, 1, 0, -half);
  dCreatePlane(w.space, 0, -1, 0, -half);
  const sim_ode::SolidBodies nothing(side_m, side_m, {});
  sim_ode::StartPlaces places(side_m, side_m, nothing);
  places.add(robots, {}, hal::RandomStream(1, "bench/ode/start"));
  for (const hal::Pose& pose : places.poses()) {
    const dBodyID body = dBodyCreate(w.world);
    dMass mass;
    dMassSetSphereTotal(&mass, 0.01, r);
    dBodySetMass(body, &mass);
    dBodySetPosition(body, pose.x_m, pose.y_m, 0);
    const dGeomID geom = dCreateSphere(w.space, r);
    dGeomSetBody(geom, body);
    const dJointID plane = dJointCreatePlane2D(w.world, nullptr);
    dJointAttach(plane, body, nullptr);
    dJointSetPlane2DXParam(plane, dParamFMax, 0.05);
    dJointSetPlane2DYParam(plane, dParamFMax, 0.05);
    dJointSetPlane2DAngleParam(plane, dParamFMax, 0.001);
    w.bodies.push_back(body);
    w.planes.push_back(plane);
  }
  w.until.assign(w.bodies.size(), 0);
  w.speed.assign(w.bodies.size(), 0);
  w.turn.assign(w.bodies.size(), 0);
}

TextbookSwarm::~TextbookSwarm() {
  dJointGroupDestroy(state_->contacts);
  dSpaceDestroy(state_->space);
  dWorldDestroy(state_->world);
}

void TextbookSwarm::step() {
  State& w = *state_;
  ++w.number;
  for (std::size_t i = 0; i < w.bodies.size(); ++i) {
    if (w.until[i] <= w.number) {
      w.until[i] = w.number + 30 + static_cast<int>(w.chance.below(31));
      const std::uint64_t kind = w.chance.below(4);
      w.speed[i] = kind < 2 ? 0 : 0.01;
      w.turn[i] = kind == 0 ? 0.7854 : kind == 1 ? -0.7854 : 0;
    }
    const dReal* q = dBodyGetQuaternion(w.bodies[i]);
    const double heading = 2 * std::atan2(q[3], q[0]);
    dJointSetPlane2DXParam(w.planes[i], dParamVel, w.speed[i] * std::cos(heading));
    dJointSetPlane2DYParam(w.planes[i], dParamVel, w.speed[i] * std::sin(heading));
    dJointSetPlane2DAngleParam(w.planes[i], dParamVel, w.turn[i]);
  }
  dSpaceCollide(w.space, &w, State::touch);
  dWorldQuickStep(w.world, 1.0 / 60);
  dJointGroupEmpty(w.contacts);
}

}  // namespace arkmesh::bench
