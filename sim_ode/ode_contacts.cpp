#include "sim_ode/ode_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "hal/fixed_math.hpp"
#include "hal/random.hpp"

namespace arkmesh::sim_ode {
namespace {

// An object this slow at a step's end stands.
constexpr double at_rest_m_s = 1e-6, at_rest_rad_s = 1e-5;

// ODE's own tables, made once and kept to the process's end: arenas may be destroyed among the last things.
struct OdeLibrary {
  OdeLibrary() { dInitODE2(0); }
};

}  // namespace

OdeContacts::OdeContacts(const ContactSettings& settings, std::uint64_t seed, std::span<const ObjectBody> objects)
    : friction_(settings.friction),
      robot_radius_m_(settings.body_radius_m),
      robot_kg_s_(settings.push_n / std::max(settings.speed_m_s, 1e-6)),
      seed_(seed) {
  static const OdeLibrary library;
  world_ = dWorldCreate();
  contacts_ = dJointGroupCreate(0);
  dWorldSetAutoDisableFlag(world_, 0);
  dWorldSetERP(world_, push_out);
  for (const ObjectBody& about : objects) {
    Object& object = objects_.emplace_back();
    object.body = dBodyCreate(world_);
    dBodySetGyroscopicMode(object.body, 0);
    set_mass(object.body, about.mass_kg, about.inertia_kg_m2);
    object.slide = dJointCreateLMotor(world_, nullptr);
    dJointAttach(object.slide, object.body, nullptr);
    dJointSetLMotorNumAxes(object.slide, 2);
    dJointSetLMotorParam(object.slide, dParamFMax, about.table_friction_n);
    dJointSetLMotorParam(object.slide, dParamFMax2, about.table_friction_n);
    object.turn = dJointCreateAMotor(world_, nullptr);
    dJointAttach(object.turn, object.body, nullptr);
    dJointSetAMotorMode(object.turn, dAMotorUser);
    dJointSetAMotorNumAxes(object.turn, 1);
    dJointSetAMotorAxis(object.turn, 0, 0, 0, 0, 1);
    dJointSetAMotorParam(object.turn, dParamFMax, about.table_friction_n_m);
    turn_friction(object);
    dBodyDisable(object.body);
  }
}

OdeContacts::~OdeContacts() {
  dJointGroupDestroy(contacts_);
  dWorldDestroy(world_);
}

void OdeContacts::set_mass(dBodyID body, double mass_kg, double inertia_kg_m2) {
  dMass mass;
  dMassSetZero(&mass);
  // nothing turns but about the vertical
  dMassSetParameters(&mass, mass_kg, 0, 0, 0, inertia_kg_m2, inertia_kg_m2, inertia_kg_m2, 0, 0, 0);
  dBodySetMass(body, &mass);
}

// ODE bounds friction along two axes by itself, so that a push between them would meet more of it. One axis follows the
// push.
void OdeContacts::turn_friction(const Object& object) {
  const double size = hal::fixed::hypot(object.push_x, object.push_y);
  const double x = size > 0 ? object.push_x / size : 1, y = size > 0 ? object.push_y / size : 0;
  dJointSetLMotorAxis(object.slide, 0, 0, x, y, 0);
  dJointSetLMotorAxis(object.slide, 1, 0, -y, x, 0);
}

dBodyID OdeContacts::pooled(std::size_t i) {
  while (pool_.size() <= i) {
    pool_.push_back(dBodyCreate(world_));
    dBodySetGyroscopicMode(pool_.back(), 0);
    set_mass(pool_.back(), pool_kg_, pool_kg_ * robot_radius_m_ * robot_radius_m_ / 2);
  }
  return pool_[i];
}

void OdeContacts::lend(int ours, const ContactBody& body, const ContactPoint& place, double step_s) {
  if (body.robot == -1 || loan_of_[index(ours)] >= 0) return;
  loan_of_[index(ours)] = static_cast<int>(loans_.size());
  const dBodyID lent = body.robot >= 0 ? pooled(robots_lent_++) : objects_[index(-2 - body.robot)].body;
  loans_.push_back({ours, lent});
  dBodyEnable(lent);
  dBodySetPosition(lent, place.x, place.y, 0);
  dBodySetLinearVel(lent, body.dx / step_s, body.dy / step_s, 0);
  dBodySetAngularVel(lent, 0, 0, body.roll / (robot_radius_m_ * step_s));
  if (body.robot >= 0) return;
  Object& object = objects_[index(-2 - body.robot)];
  object.push_x = body.dx;
  object.push_y = body.dy;
}

void OdeContacts::attach(const Contact& contact, const ContactPoint& point, std::span<const ContactBody> bodies,
                         double step_s) {
  const ContactBody &a = bodies[index(contact.a)], &b = bodies[index(contact.b)];
  dContact touch{};
  touch.surface.mode = dContactApprox1_1 | dContactMu2 | dContactFDir1 | dContactMotionN;
  touch.surface.mu = friction_;
  touch.surface.mu2 = 0;  // nothing moves out of the plane
  // ODE's normal points into its first body; negative motion lets the bodies close their gap
  touch.surface.motionN = -allowed_m(contact.gap_m) / step_s;
  touch.geom.normal[0] = -contact.normal_x;
  touch.geom.normal[1] = -contact.normal_y;
  touch.fdir1[0] = -contact.normal_y;
  touch.fdir1[1] = contact.normal_x;
  touch.geom.pos[0] = point.x;
  touch.geom.pos[1] = point.y;
  const auto body_of = [this](int ours) {
    const int loan = loan_of_[index(ours)];
    return loan < 0 ? nullptr : loans_[index(loan)].body;
  };
  dJointAttach(dJointCreateContact(world_, contacts_, &touch), body_of(contact.a), body_of(contact.b));
  if (b.robot >= -1) return;
  Object& object = objects_[index(-2 - b.robot)];
  const double closing = a.dx * contact.normal_x + a.dy * contact.normal_y - contact.gap_m;
  object.push_x += std::max(0.0, closing) * contact.normal_x;
  object.push_y += std::max(0.0, closing) * contact.normal_y;
}

void OdeContacts::solve(std::span<Contact> contacts, std::span<const int> sliding, std::span<const ContactPoint> points,
                        std::span<const ContactPoint> places, std::vector<ContactBody>& bodies, int iterations,
                        double step_s) {
  // only ratios count while there are no objects
  const double robot_kg = objects_.empty() ? 1 : robot_kg_s_ * step_s;
  if (robot_kg != pool_kg_) {
    pool_kg_ = robot_kg;
    for (const dBodyID body : pool_) set_mass(body, robot_kg, robot_kg * robot_radius_m_ * robot_radius_m_ / 2);
  }
  const std::size_t lent_before = robots_lent_;
  robots_lent_ = 0;
  loans_.clear();
  loan_of_.assign(bodies.size(), -1);
  for (const Contact& contact : contacts)
    for (const int ours : {contact.a, contact.b}) lend(ours, bodies[index(ours)], places[index(ours)], step_s);
  for (const int ours : sliding) lend(ours, bodies[index(ours)], places[index(ours)], step_s);
  for (std::size_t k = robots_lent_; k < lent_before; ++k) dBodyDisable(pool_[k]);

  for (Contact& contact : contacts) {
    contact.push_m = contact.rub_m = 0;  // ODE's are not asked for
    const ContactPoint& a = places[index(contact.a)];
    attach(contact,
           bodies[index(contact.a)].robot >= 0
               ? ContactPoint{a.x + robot_radius_m_ * contact.normal_x, a.y + robot_radius_m_ * contact.normal_y}
               : points[index(contact.source)],
           bodies, step_s);
  }
  for (const Object& object : objects_) turn_friction(object);
  dRandSetSeed(hal::mix64(seed_ + steps_ * 0x9e3779b97f4a7c15ULL) & 0xFFFFFFFF);
  dWorldSetQuickStepNumIterations(world_, iterations);
  dWorldQuickStep(world_, step_s);
  dJointGroupEmpty(contacts_);
  ++steps_;

  for (const Loan& loan : loans_) {
    ContactBody& body = bodies[index(loan.ours)];
    const dReal* velocity = dBodyGetLinearVel(loan.body);
    const double turn = dBodyGetAngularVel(loan.body)[2];
    drift_m_ = std::max(drift_m_, std::abs(dBodyGetPosition(loan.body)[2]));
    const bool rests =
        body.robot < 0 && std::abs(velocity[0]) + std::abs(velocity[1]) < at_rest_m_s && std::abs(turn) < at_rest_rad_s;
    body.dx = rests ? 0 : velocity[0] * step_s;
    body.dy = rests ? 0 : velocity[1] * step_s;
    body.roll = rests ? 0 : turn * robot_radius_m_ * step_s;
    if (body.robot < 0) dBodyDisable(loan.body);
  }
}

}  // namespace arkmesh::sim_ode
