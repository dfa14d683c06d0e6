// Contacts are constraints on the step ahead: two bodies may close their gap but not go beyond, so nothing has to be
// pushed apart afterwards. A contact alone is solved at once, a small cluster by repeating that for each of its
// contacts in turn; for a crowd ODE's quick step does the same with less work per contact.
#include "sim_ode/contact_solver.hpp"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>

#include "hal/platforms/kilobot/body.hpp"
#include "hal/random.hpp"
#include "sim_ode/host/reception.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double radius_m = hal::kilobot::body_radius_m;
constexpr double step_s = tick_us * 1e-6;
// Share of a penetration that is undone in a step.
constexpr double push_out = 0.5;
constexpr int ode_iterations = 8;
// Contacts of a cluster that is not worth the way to ODE (measured: at 400 robots/m2 the way costs a fifth), and when
// it is solved.
constexpr std::size_t small_cluster = 256;
constexpr int max_rounds = 16;
constexpr double solved_m = 1e-5;

double allowed_m(double gap_m) {
  return gap_m > 0 ? gap_m : push_out * gap_m;
}

// ODE's own tables, made once and kept to the process's end: arenas may be destroyed among the last things.
struct OdeLibrary {
  OdeLibrary() { dInitODE2(0); }
};

}  // namespace

// A world without gravity or joints other than contacts; its bodies are lent to the robots that need one in a step.
struct ContactSolver::Ode {
  Ode() {
    static const OdeLibrary library;
    world = dWorldCreate();
    contacts = dJointGroupCreate(0);
    dWorldSetQuickStepNumIterations(world, ode_iterations);
    dWorldSetAutoDisableFlag(world, 0);
  }
  ~Ode() {
    dJointGroupDestroy(contacts);
    dWorldDestroy(world);
  }
  dBodyID body(std::size_t i) {
    while (bodies.size() <= i) {
      bodies.push_back(dBodyCreate(world));
      // unit mass: only ratios count where every body weighs the same
      dMass mass;
      dMassSetZero(&mass);
      const double about_any_axis = radius_m * radius_m / 2;
      dMassSetParameters(&mass, 1, 0, 0, 0, about_any_axis, about_any_axis, about_any_axis, 0, 0, 0);
      dBodySetMass(bodies.back(), &mass);
      dBodySetGyroscopicMode(bodies.back(), 0);
    }
    return bodies[i];
  }
  dWorldID world;
  dJointGroupID contacts;
  std::vector<dBodyID> bodies;
  std::vector<int> lent_to;  // our body, by ODE's in use
  std::vector<int> body_of;  // our body -> ODE's in use, -1
};

ContactSolver::ContactSolver(double friction, std::uint64_t seed)
    : friction_(friction), seed_(seed), ode_(std::make_unique<Ode>()) {}

ContactSolver::~ContactSolver() = default;

void ContactSolver::clear() {
  bodies_.clear();
  clusters_.clear();
  contacts_.clear();
  ordered_.clear();
}

int ContactSolver::add_body(int robot, double dx_m, double dy_m, double roll_m) {
  const int body = static_cast<int>(bodies_.size());
  bodies_.push_back({dx_m, dy_m, roll_m, robot, 0});
  clusters_.push_back({body, 0, 0, false});
  return body;
}

void ContactSolver::add(int a, int b, double normal_x, double normal_y, double gap_m, bool closes, double push_m,
                        double rub_m, int source) {
  contacts_.push_back({a, b, normal_x, normal_y, gap_m, push_m, rub_m, 0.5, 0, source});
  const int from = root(a), to = root(b), low = std::min(from, to), high = std::max(from, to);
  closes |= clusters_[index(high)].closes;
  clusters_[index(high)].parent = low;
  clusters_[index(low)].closes |= closes;
}

void ContactSolver::add_wall(int a, double normal_x, double normal_y, double gap_m, bool closes, double push_m,
                             double rub_m, int source) {
  // each piece of wall is a body of its own that no correction reaches
  const int wall = add_body(-1, 0, 0, 0);
  contacts_.push_back({a, wall, normal_x, normal_y, gap_m, push_m, rub_m, 1, 0, source});
  clusters_[index(root(a))].closes |= closes;
}

int ContactSolver::root(int body) {
  while (clusters_[index(body)].parent != body)
    body = clusters_[index(body)].parent = clusters_[index(clusters_[index(body)].parent)].parent;
  return body;
}

// Puts the contacts that count into ordered_: small clusters, in order of appearance, then the contacts of large ones.
// Returns where the latter begin.
std::size_t ContactSolver::order_by_cluster() {
  std::size_t count = 0;
  for (Contact& contact : contacts_) {
    contact.seen_at = root(contact.a);
    Cluster& cluster = clusters_[index(contact.seen_at)];
    if (!cluster.closes) continue;
    ++cluster.contacts;
    ++count;
  }
  ordered_.resize(count);
  std::size_t small_end = 0;
  for (const Contact& contact : contacts_) {
    Cluster& cluster = clusters_[index(contact.seen_at)];
    if (cluster.contacts <= 0 || cluster.contacts > static_cast<int>(small_cluster)) continue;
    cluster.at = static_cast<int>(small_end);
    small_end += index(cluster.contacts);
    cluster.contacts = -cluster.contacts;
  }
  std::size_t large_end = small_end;
  for (const Contact& contact : contacts_) {
    Cluster& cluster = clusters_[index(contact.seen_at)];
    if (!cluster.closes) continue;
    ordered_[cluster.contacts > 0 ? large_end++ : index(cluster.at++)] = contact;
  }
  return small_end;
}

void ContactSolver::solve(std::uint64_t step, std::span<const double> x, std::span<const double> y) {
  const std::size_t small_end = order_by_cluster();
  const std::span<Contact> all(ordered_);
  for (std::size_t at = 0; at < small_end;) {
    const std::size_t size = index(-clusters_[index(all[at].seen_at)].contacts);
    solve_small(all.subspan(at, size));
    at += size;
  }
  if (small_end < all.size()) solve_with_ode(all.subspan(small_end), step, x, y);
}

void ContactSolver::apply(const Contact& contact, double push_m, double rub_m) {
  Body &a = bodies_[index(contact.a)], &b = bodies_[index(contact.b)];
  // across the normal: to its left
  const double x = push_m * contact.normal_x - rub_m * contact.normal_y,
               y = push_m * contact.normal_y + rub_m * contact.normal_x;
  a.dx -= x;
  a.dy -= y;
  a.roll -= 2 * rub_m;  // a disc's r^2 / I
  if (contact.wall()) return;
  b.dx += x;
  b.dy += y;
  b.roll -= 2 * rub_m;
}

// Makes one contact hold as if it were the only one: what the impulse equations with friction give at once. Motions of
// this step stand for velocities. Returns by how much it moved a body.
double ContactSolver::relax(Contact& contact) {
  const Body &a = bodies_[index(contact.a)], &b = bodies_[index(contact.b)];
  const double x = a.dx - b.dx, y = a.dy - b.dy;
  const double closing = x * contact.normal_x + y * contact.normal_y, allowed = allowed_m(contact.gap_m);
  if (closing <= allowed && contact.push_m == 0) return 0;
  const double push = std::max(0.0, contact.push_m + (closing - allowed) * contact.share);
  // sliding at the touching point; a disc's tangential compliance is 1 + r^2 / I = 3
  const double sliding = y * contact.normal_x - x * contact.normal_y + a.roll + b.roll;
  const double most = friction_ * push, rub = std::clamp(contact.rub_m + sliding * (contact.share / 3), -most, most);
  const double more_push = push - contact.push_m, more_rub = rub - contact.rub_m;
  contact.push_m = push;
  contact.rub_m = rub;
  apply(contact, more_push, more_rub);
  return std::abs(more_push) + std::abs(more_rub);
}

void ContactSolver::solve_small(std::span<Contact> cluster) {
  if (cluster.size() == 1) {
    cluster[0].push_m = cluster[0].rub_m = 0;
    relax(cluster[0]);
    return;
  }
  // what held in the last step mostly holds in this one
  for (Contact& contact : cluster) {
    contact.seen_at = -1;
    if (contact.push_m != 0) apply(contact, contact.push_m, contact.rub_m);
  }
  for (const Contact& contact : cluster) bodies_[index(contact.a)].moved_at = bodies_[index(contact.b)].moved_at = 0;
  // from the second round on only where a body has moved since
  now_ = 0;
  for (int round = 0; round < max_rounds; ++round) {
    bool moved = false;
    for (Contact& contact : cluster) {
      Body &a = bodies_[index(contact.a)], &b = bodies_[index(contact.b)];
      if (a.moved_at <= contact.seen_at && b.moved_at <= contact.seen_at) continue;
      contact.seen_at = ++now_;
      if (relax(contact) < solved_m) continue;
      moved = true;
      a.moved_at = b.moved_at = now_;
    }
    if (!moved) return;
  }
}

void ContactSolver::solve_with_ode(std::span<Contact> contacts, std::uint64_t step, std::span<const double> x,
                                   std::span<const double> y) {
  Ode& ode = *ode_;
  ode.lent_to.clear();
  ode.body_of.assign(bodies_.size(), -1);
  for (const Contact& contact : contacts) {
    for (int ours : {contact.a, contact.b}) {
      const Body& body = bodies_[index(ours)];
      if (body.robot < 0 || ode.body_of[index(ours)] >= 0) continue;
      const dBodyID lent = ode.body(ode.lent_to.size());
      ode.body_of[index(ours)] = static_cast<int>(ode.lent_to.size());
      ode.lent_to.push_back(ours);
      dBodyEnable(lent);
      dBodySetPosition(lent, x[index(body.robot)], y[index(body.robot)], 0);
      dBodySetLinearVel(lent, body.dx / step_s, body.dy / step_s, 0);
      dBodySetAngularVel(lent, 0, 0, body.roll / (radius_m * step_s));
    }
  }
  for (std::size_t k = ode.lent_to.size(); k < ode.bodies.size(); ++k) dBodyDisable(ode.bodies[k]);

  for (Contact& contact : contacts) {
    contact.push_m = contact.rub_m = 0;  // ODE's are not asked for
    const std::size_t a = index(bodies_[index(contact.a)].robot);
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
    touch.geom.pos[0] = x[a] + radius_m * contact.normal_x;
    touch.geom.pos[1] = y[a] + radius_m * contact.normal_y;
    dJointAttach(dJointCreateContact(ode.world, ode.contacts, &touch), ode.bodies[index(ode.body_of[index(contact.a)])],
                 contact.wall() ? nullptr : ode.bodies[index(ode.body_of[index(contact.b)])]);
  }
  dRandSetSeed(hal::mix64(seed_ + step * 0x9e3779b97f4a7c15ULL) & 0xFFFFFFFF);
  dWorldQuickStep(ode.world, step_s);
  dJointGroupEmpty(ode.contacts);
  ++ode_steps_;

  for (std::size_t k = 0; k < ode.lent_to.size(); ++k) {
    Body& body = bodies_[index(ode.lent_to[k])];
    const dReal* velocity = dBodyGetLinearVel(ode.bodies[k]);
    drift_m_ = std::max(drift_m_, std::abs(dBodyGetPosition(ode.bodies[k])[2]));
    body.dx = velocity[0] * step_s;
    body.dy = velocity[1] * step_s;
    body.roll = dBodyGetAngularVel(ode.bodies[k])[2] * radius_m * step_s;
  }
}

}  // namespace arkmesh::sim_ode
