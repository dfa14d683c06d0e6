// Contacts are constraints on the step ahead: two bodies may close their gap but not go beyond, so nothing has to be pushed
// apart afterwards. A contact alone is solved at once, a small cluster by repeating that for each of its contacts in turn; for a
// crowd ODE's quick step does the same with less work per contact.
#include "sim_ode/contact_world.hpp"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>

#include "hal/arena_config.hpp"
#include "hal/random.hpp"
#include "sim_ode/reception.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double radius_m = hal::kilobot_radius_m;
constexpr double step_s = tick_us * 1e-6;
// No two robots come nearer to each other than this in one step (two pivots at the largest duty: 1.2 mm).
constexpr double reach_m = 0.0015;
// Pairs are listed while nearer than a diameter plus this; the list then serves many steps.
constexpr double skin_m = 0.02;
// Share of a penetration that is undone in a step.
constexpr double push_out = 0.5;
constexpr int iterations = 8;
// Contacts of a cluster that is not worth the way to ODE (measured: at 400 robots/m2 the way costs a fifth), and when it is solved.
constexpr std::size_t small_cluster = 256;
constexpr int most_rounds = 16;
constexpr double solved_m = 1e-6;

// ODE's own tables, made once and kept to the process's end: arenas may be destroyed among the last things.
struct OdeLibrary {
  OdeLibrary() { dInitODE2(0); }
};

}  // namespace

// A world without gravity or joints other than contacts; its bodies are lent to the robots that need one in a step.
struct ContactWorld::Ode {
  Ode() {
    static const OdeLibrary library;
    world = dWorldCreate();
    contacts = dJointGroupCreate(0);
    dWorldSetQuickStepNumIterations(world, iterations);
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
  std::vector<int> robots;      // of the bodies in use
  std::vector<int> body_of;     // robot -> body in use, -1
};

ContactWorld::ContactWorld(double width_m, double height_m, double friction, std::uint64_t seed, const std::vector<hal::Pose>& start)
    : width_m_(width_m), height_m_(height_m), friction_(friction), seed_(seed), grid_(width_m, height_m, 2 * radius_m + skin_m),
      ode_(std::make_unique<Ode>()) {
  const std::size_t n = start.size();
  for (const hal::Pose& pose : start) {
    x_.push_back(pose.x_m);
    y_.push_back(pose.y_m);
    cos_.push_back(std::cos(pose.heading_rad));
    sin_.push_back(std::sin(pose.heading_rad));
  }
  x0_ = x_;
  y0_ = y_;
  cos0_ = cos_;
  sin0_ = sin_;
  for (std::vector<double>* zeros : {&ahead_, &left_, &turn_sin_, &turn_, &dx_, &dy_, &dturn_}) zeros->assign(n, 0);
  turn_cos_.assign(n, 1);
  touched_.assign(n, 0);
  on_table_.assign(n, 1);
  parent_.assign(n, -1);
  cluster_size_.assign(n, 0);
  cluster_at_.assign(n, 0);
  ode_->body_of.assign(n, -1);
}

ContactWorld::~ContactWorld() = default;

void ContactWorld::set_velocity(int robot, const Velocity& velocity) {
  const std::size_t i = index(robot);
  const double turn = velocity.turn_rad_s * step_s;
  const double half_cos = std::cos(turn / 2), half_sin = std::sin(turn / 2);
  ahead_[i] = step_s * (velocity.ahead_m_s * half_cos - velocity.left_m_s * half_sin);
  left_[i] = step_s * (velocity.ahead_m_s * half_sin + velocity.left_m_s * half_cos);
  turn_[i] = turn;
  turn_cos_[i] = std::cos(turn);
  turn_sin_[i] = std::sin(turn);
}

void ContactWorld::place(int robot, const hal::Pose& pose) {
  const std::size_t i = index(robot);
  longest_path_m_ += std::hypot(pose.x_m - x_[i], pose.y_m - y_[i]);
  slack_m_ = -1;  // pairs are listed anew
  x_[i] = x0_[i] = pose.x_m;
  y_[i] = y0_[i] = pose.y_m;
  cos_[i] = cos0_[i] = std::cos(pose.heading_rad);
  sin_[i] = sin0_[i] = std::sin(pose.heading_rad);
  on_table_[i] = 1;
}

void ContactWorld::take_off(int robot) {
  // beyond anybody's reach, each on a shelf of its own
  const std::size_t i = index(robot);
  place(robot, {10 * width_m_ + 10 + robot, 10 * height_m_ + 10, std::atan2(sin_[i], cos_[i])});
  on_table_[i] = 0;
}

void ContactWorld::step() {
  const std::size_t n = x_.size();
  x0_ = x_;
  y0_ = y_;
  cos0_ = cos_;
  sin0_ = sin_;

  // where everybody would go alone
  double farthest2 = 0;
  for (std::size_t i = 0; i < n; ++i) {
    dx_[i] = cos_[i] * ahead_[i] - sin_[i] * left_[i];
    dy_[i] = sin_[i] * ahead_[i] + cos_[i] * left_[i];
    farthest2 = std::max(farthest2, ahead_[i] * ahead_[i] + left_[i] * left_[i]);
  }
  const double farthest = std::sqrt(farthest2);

  if (slack_m_ < 0) find_pairs();
  find_contacts();
  if (!contacts_.empty()) {
    spread_contacts();
    make_clusters();
  }

  for (std::size_t i = 0; i < n; ++i) {
    x_[i] += dx_[i];
    y_[i] += dy_[i];
    const double c = cos_[i];
    cos_[i] = c * turn_cos_[i] - sin_[i] * turn_sin_[i];
    sin_[i] = c * turn_sin_[i] + sin_[i] * turn_cos_[i];
  }

  // those in contact turned by another angle, and perhaps went farther
  double path = farthest;
  for (const Contact* contact : joined_) {
    for (int robot : {contact->a, contact->b}) {
      if (robot < 0 || !touched_[index(robot)]) continue;
      const std::size_t i = index(robot);
      touched_[i] = 0;
      ++totals_.touching;
      const double half = dturn_[i] / 2;  // small: a tangent half-angle turn, exact in length
      const double scale = 1 / (1 + half * half), c = (1 - half * half) * scale, s = 2 * half * scale;
      cos_[i] = cos0_[i] * c - sin0_[i] * s;
      sin_[i] = cos0_[i] * s + sin0_[i] * c;
      path = std::max(path, std::sqrt(dx_[i] * dx_[i] + dy_[i] * dy_[i]));
    }
  }
  measure_penetration();
  slack_m_ -= 2 * path;  // two robots may have come nearer by twice the path
  longest_path_m_ += path;
  ++totals_.steps;
}

// Lists the pairs that may touch while nobody moves by more than half the skin, and keeps headings of unit length.
void ContactWorld::find_pairs() {
  grid_.build(x_, y_);
  pairs_.clear();
  constexpr double near_m = 2 * radius_m + skin_m;
  for (int i = 0; i < robots(); ++i) {
    const double x = x_[index(i)], y = y_[index(i)];
    grid_.visit_near(x, y, near_m, [&](int j) {
      if (j <= i) return;
      const double dx = x_[index(j)] - x, dy = y_[index(j)] - y;
      if (dx * dx + dy * dy < near_m * near_m) pairs_.emplace_back(i, j);
    });
    const double length = std::sqrt(cos_[index(i)] * cos_[index(i)] + sin_[index(i)] * sin_[index(i)]);
    cos_[index(i)] /= length;
    sin_[index(i)] /= length;
  }
  slack_m_ = skin_m - reach_m;
}

void ContactWorld::find_contacts() {
  contacts_.clear();
  maybe_.clear();
  joined_.clear();
  const auto add = [this](const Contact& contact, double closing) {
    if (contact.gap_m - closing < 0) {
      contacts_.push_back(contact);
      contacts_.back().certain = true;
      touched_[index(contact.a)] = 1;
      if (contact.b >= 0) touched_[index(contact.b)] = 1;
    } else {
      maybe_.push_back(contact);
    }
  };

  constexpr double near_m = 2 * radius_m + reach_m;
  for (const auto& [a, b] : pairs_) {
    const std::size_t i = index(a), j = index(b);
    const double x = x_[j] - x_[i], y = y_[j] - y_[i], d2 = x * x + y * y;
    if (d2 >= near_m * near_m) continue;
    const double d = std::max(std::sqrt(d2), 1e-9), nx = x / d, ny = y / d;
    add({a, b, nx, ny, d - 2 * radius_m, false, 0, 0, 0}, (dx_[i] - dx_[j]) * nx + (dy_[i] - dy_[j]) * ny);
  }

  const double free_x = width_m_ / 2 - radius_m, free_y = height_m_ / 2 - radius_m;
  for (int a = 0; a < robots(); ++a) {
    const std::size_t i = index(a);
    const double gap_x = free_x - std::abs(x_[i]), gap_y = free_y - std::abs(y_[i]);
    if ((gap_x >= reach_m && gap_y >= reach_m) || !on_table_[i]) continue;
    if (gap_x < reach_m) {
      const double side = x_[i] < 0 ? -1 : 1;
      add({a, -1, side, 0, gap_x, false, 0, 0, 0}, dx_[i] * side);
    }
    if (gap_y < reach_m) {
      const double side = y_[i] < 0 ? -1 : 1;
      add({a, -1, 0, side, gap_y, false, 0, 0, 0}, dy_[i] * side);
    }
  }
}

// A robot in contact may be pushed against others: those contacts join, and so on.
void ContactWorld::spread_contacts() {
  for (bool again = true; again;) {
    again = false;
    for (Contact& contact : maybe_) {
      if (contact.certain) continue;
      const bool touches = touched_[index(contact.a)] || (contact.b >= 0 && touched_[index(contact.b)]);
      if (!touches) continue;
      contact.certain = again = true;
      touched_[index(contact.a)] = 1;
      if (contact.b >= 0) touched_[index(contact.b)] = 1;
    }
  }
  for (Contact& contact : contacts_) joined_.push_back(&contact);
  for (Contact& contact : maybe_)
    if (contact.certain) joined_.push_back(&contact);
  totals_.contacts += joined_.size();
}

int ContactWorld::root(int robot) {
  while (parent_[index(robot)] != robot) robot = parent_[index(robot)] = parent_[index(parent_[index(robot)])];
  return robot;
}

void ContactWorld::make_clusters() {
  for (const Contact* contact : joined_)
    for (int robot : {contact->a, contact->b})
      if (robot >= 0) {
        parent_[index(robot)] = robot;
        cluster_size_[index(robot)] = 0;
        dturn_[index(robot)] = turn_[index(robot)];
      }
  for (const Contact* contact : joined_)
    if (contact->b >= 0) {
      const int a = root(contact->a), b = root(contact->b);
      parent_[index(std::max(a, b))] = std::min(a, b);
    }
  for (Contact* contact : joined_) ++cluster_size_[index(contact->cluster = root(contact->a))];

  // ordered by cluster: small ones, in order of appearance, then the contacts of large ones
  ordered_.resize(joined_.size());
  std::size_t small_end = 0;
  for (Contact* contact : joined_) {
    int& size = cluster_size_[index(contact->cluster)];
    if (size <= 0 || size > static_cast<int>(small_cluster)) continue;
    cluster_at_[index(contact->cluster)] = static_cast<int>(small_end);
    small_end += static_cast<std::size_t>(size);
    size = -size;  // has its place
  }
  std::size_t large_end = small_end;
  for (Contact* contact : joined_) {
    const bool large = cluster_size_[index(contact->cluster)] > 0;
    ordered_[large ? large_end++ : static_cast<std::size_t>(cluster_at_[index(contact->cluster)]++)] = contact;
  }
  const std::span<Contact* const> all(ordered_);
  for (std::size_t at = 0; at < small_end;) {
    const auto size = static_cast<std::size_t>(-cluster_size_[index(all[at]->cluster)]);
    solve_small(all.subspan(at, size));
    at += size;
  }
  if (small_end < all.size()) solve_with_ode(all.subspan(small_end));
}

// Makes one contact hold as if it were the only one: what the impulse equations with friction give at once. Motions of this step
// stand for velocities. Returns by how much it moved a body.
double ContactWorld::relax(Contact& contact) {
  const std::size_t a = index(contact.a);
  const double nx = contact.normal_x, ny = contact.normal_y, tx = -ny, ty = nx;
  const bool wall = contact.b < 0;
  const std::size_t b = wall ? a : index(contact.b);
  const double bx = wall ? 0 : dx_[b], by = wall ? 0 : dy_[b], bturn = wall ? 0 : dturn_[b];
  const double bodies = wall ? 1 : 2;

  const double closing = (dx_[a] - bx) * nx + (dy_[a] - by) * ny;
  const double allowed = contact.gap_m > 0 ? contact.gap_m : push_out * contact.gap_m;
  if (closing <= allowed && contact.push == 0) return 0;
  const double push = std::max(0.0, contact.push + (closing - allowed) / bodies);
  const double more_push = push - contact.push;
  contact.push = push;
  // sliding at the touching point; a disc's tangential compliance is 1 + r^2 / I = 3
  const double sliding = (dx_[a] - bx) * tx + (dy_[a] - by) * ty + radius_m * (dturn_[a] + bturn);
  const double rub = std::clamp(contact.rub + sliding / (3 * bodies), -friction_ * push, friction_ * push);
  const double more_rub = rub - contact.rub;
  contact.rub = rub;

  dx_[a] -= more_push * nx + more_rub * tx;
  dy_[a] -= more_push * ny + more_rub * ty;
  dturn_[a] -= 2 * more_rub / radius_m;
  if (!wall) {
    dx_[b] += more_push * nx + more_rub * tx;
    dy_[b] += more_push * ny + more_rub * ty;
    dturn_[b] -= 2 * more_rub / radius_m;
  }
  return std::abs(more_push) + std::abs(more_rub);
}

void ContactWorld::solve_small(std::span<Contact* const> cluster) {
  for (int round = 0; round < most_rounds; ++round) {
    double moved = 0;
    for (Contact* contact : cluster) moved = std::max(moved, relax(*contact));
    if (moved < solved_m || cluster.size() == 1) return;
  }
}

void ContactWorld::solve_with_ode(std::span<Contact* const> contacts) {
  Ode& ode = *ode_;
  // bodies in robot order, so that equal situations give equal steps
  ode.robots.clear();
  for (const Contact* contact : contacts) {
    for (int robot : {contact->a, contact->b})
      if (robot >= 0 && ode.body_of[index(robot)] < 0) {
        ode.body_of[index(robot)] = 0;
        ode.robots.push_back(robot);
      }
  }
  std::sort(ode.robots.begin(), ode.robots.end());
  for (std::size_t k = 0; k < ode.robots.size(); ++k) {
    const std::size_t i = index(ode.robots[k]);
    const dBodyID body = ode.body(k);
    ode.body_of[i] = static_cast<int>(k);
    dBodyEnable(body);
    dBodySetPosition(body, x_[i], y_[i], 0);
    dBodySetLinearVel(body, dx_[i] / step_s, dy_[i] / step_s, 0);
    dBodySetAngularVel(body, 0, 0, dturn_[i] / step_s);
  }
  for (std::size_t k = ode.robots.size(); k < ode.bodies.size(); ++k) dBodyDisable(ode.bodies[k]);

  for (const Contact* contact : contacts) {
    const std::size_t a = index(contact->a);
    dContact touch{};
    touch.surface.mode = dContactApprox1_1 | dContactMu2 | dContactFDir1 | dContactMotionN;
    touch.surface.mu = friction_;
    touch.surface.mu2 = 0;  // nothing moves out of the plane
    // ODE's normal points into its first body; negative motion lets the bodies close their gap
    touch.surface.motionN = -(contact->gap_m > 0 ? contact->gap_m : push_out * contact->gap_m) / step_s;
    touch.geom.normal[0] = -contact->normal_x;
    touch.geom.normal[1] = -contact->normal_y;
    touch.fdir1[0] = -contact->normal_y;
    touch.fdir1[1] = contact->normal_x;
    touch.geom.pos[0] = x_[a] + radius_m * contact->normal_x;
    touch.geom.pos[1] = y_[a] + radius_m * contact->normal_y;
    dJointAttach(dJointCreateContact(ode.world, ode.contacts, &touch), ode.bodies[static_cast<std::size_t>(ode.body_of[a])],
                 contact->b < 0 ? nullptr : ode.bodies[static_cast<std::size_t>(ode.body_of[index(contact->b)])]);
  }
  dRandSetSeed(hal::mix64(seed_ + totals_.steps * 0x9e3779b97f4a7c15ULL) & 0xFFFFFFFF);
  dWorldQuickStep(ode.world, step_s);
  dJointGroupEmpty(ode.contacts);
  ++totals_.ode_steps;

  for (std::size_t k = 0; k < ode.robots.size(); ++k) {
    const std::size_t i = index(ode.robots[k]);
    const dReal* velocity = dBodyGetLinearVel(ode.bodies[k]);
    dx_[i] = velocity[0] * step_s;
    dy_[i] = velocity[1] * step_s;
    dturn_[i] = dBodyGetAngularVel(ode.bodies[k])[2] * step_s;
    ode.body_of[i] = -1;
  }
}

void ContactWorld::measure_penetration() {
  for (const Contact* contact : joined_) {
    const std::size_t a = index(contact->a);
    double deep;
    if (contact->b >= 0) {
      const double x = x_[index(contact->b)] - x_[a], y = y_[index(contact->b)] - y_[a];
      deep = 2 * radius_m - std::sqrt(x * x + y * y);
    } else {
      deep = contact->normal_x != 0 ? std::abs(x_[a]) + radius_m - width_m_ / 2 : std::abs(y_[a]) + radius_m - height_m_ / 2;
    }
    totals_.deepest_m = std::max(totals_.deepest_m, deep);
    totals_.deep += deep > 0.001;
  }
}

hal::Pose ContactWorld::pose(int robot, double share) const {
  const std::size_t i = index(robot);
  const auto between = [share](double from, double to) { return from + share * (to - from); };
  return {between(x0_[i], x_[i]), between(y0_[i], y_[i]), std::atan2(between(sin0_[i], sin_[i]), between(cos0_[i], cos_[i]))};
}

}  // namespace arkmesh::sim_ode
