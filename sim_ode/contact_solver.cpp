// Contacts are constraints on the step ahead: two bodies may close their gap but not go beyond, so nothing has to be
// pushed apart afterwards.
#include "sim_ode/contact_solver.hpp"

#include <algorithm>
#include <cmath>

namespace arkmesh::sim_ode {
namespace {

// A robot's mass and an object's may differ by far, which takes more rounds.
constexpr int least_rounds_with_objects = 60;
// Fast: contacts of a cluster that is not worth the way to ODE (measured: at 400 robots/m2 the way costs a fifth), and
// when a cluster is solved.
constexpr int largest_here = 256;
constexpr int max_rounds = 16;
constexpr double solved_m = 4.5e-6;

}  // namespace

ContactSolver::ContactSolver(const ContactSettings& settings, std::uint64_t seed, std::span<const ObjectBody> objects)
    : solver_(settings.solver),
      rounds_(settings.ode_rounds),
      friction_(settings.friction),
      ode_(settings, seed, objects) {}

void ContactSolver::clear() {
  bodies_.clear();
  places_.clear();
  clusters_.clear();
  contacts_.clear();
  ordered_.clear();
  points_.clear();
  sliding_.clear();
}

int ContactSolver::add_body(int robot, double x_m, double y_m, double dx_m, double dy_m, double roll_m) {
  const int body = static_cast<int>(bodies_.size());
  bodies_.push_back({dx_m, dy_m, roll_m, robot, 0});
  places_.push_back({x_m, y_m});
  const bool slides = robot < -1 && (dx_m != 0 || dy_m != 0 || roll_m != 0);
  clusters_.push_back({body, 0, 0, slides, robot < -1 ? Company::objects : Company::robots});
  if (slides) sliding_.push_back(body);
  return body;
}

void ContactSolver::join(int a, int b, bool closes, Company company) {
  const int from = root(a), to = root(b), low = std::min(from, to), high = std::max(from, to);
  const Cluster &one = clusters_[index(low)], &other = clusters_[index(high)];
  closes |= one.closes || other.closes;
  company = std::max({company, one.company, other.company});
  clusters_[index(high)].parent = low;
  clusters_[index(low)].closes = closes;
  clusters_[index(low)].company = company;
}

// Each piece of wall is a body of its own that no correction reaches.
int ContactSolver::add_fixed() {
  return add_body(-1, 0, 0, 0, 0, 0);
}

void ContactSolver::add(int a, int b, double normal_x, double normal_y, double gap_m, bool closes, double push_m,
                        double rub_m, int source) {
  contacts_.push_back({a, b, normal_x, normal_y, gap_m, push_m, rub_m, 0.5, 0, source});
  join(a, b, closes, Company::robots);
}

void ContactSolver::add_wall(int a, double normal_x, double normal_y, double gap_m, bool closes, double push_m,
                             double rub_m, int source) {
  const int wall = add_fixed();
  contacts_.push_back({a, wall, normal_x, normal_y, gap_m, push_m, rub_m, 1, 0, source});
  clusters_[index(root(a))].closes |= closes;
}

void ContactSolver::add_solid(int a, int b, double normal_x, double normal_y, double gap_m, bool closes, int source) {
  const float share = b < 0 ? 1 : 0.5F;
  if (b < 0) b = add_fixed();
  contacts_.push_back({a, b, normal_x, normal_y, gap_m, 0, 0, share, 0, source, true});
  join(a, b, closes, Company::obstacles);
}

void ContactSolver::add_object(int a, int b, double normal_x, double normal_y, double gap_m, ContactPoint at) {
  const int source = static_cast<int>(points_.size());
  points_.push_back(at);
  add_solid(a, b, normal_x, normal_y, gap_m, false, source);
}

int ContactSolver::root(int body) {
  while (clusters_[index(body)].parent != body)
    body = clusters_[index(body)].parent = clusters_[index(clusters_[index(body)].parent)].parent;
  return body;
}

ContactSolver::Way ContactSolver::way(const Cluster& cluster) const {
  if (cluster.company == Company::objects) return by_ode_with_objects;
  const bool fast = solver_ == Solver::fast && cluster.company == Company::robots;
  return std::abs(cluster.contacts) <= (fast ? largest_here : 1) ? here : by_ode;
}

// Puts the contacts that count into ordered_, way by way: clusters that are solved here in order of appearance, each in
// one piece; those of ODE as they come.
void ContactSolver::order_by_cluster() {
  std::size_t count = 0, of_way[ways] = {};
  for (Contact& contact : contacts_) {
    contact.seen_at = root(contact.a);
    Cluster& cluster = clusters_[index(contact.seen_at)];
    if (!cluster.closes) continue;
    ++cluster.contacts;
    ++count;
  }
  ordered_.resize(count);
  for (const Contact& contact : contacts_) {
    Cluster& cluster = clusters_[index(contact.seen_at)];
    if (cluster.contacts <= 0) continue;
    const Way taken = way(cluster);
    cluster.at = static_cast<int>(of_way[taken]);
    of_way[taken] += index(cluster.contacts);
    cluster.contacts = -cluster.contacts;
  }
  end_of_[here] = of_way[here];
  end_of_[by_ode] = end_of_[here] + of_way[by_ode];
  end_of_[by_ode_with_objects] = count;
  for (const Contact& contact : contacts_) {
    Cluster& cluster = clusters_[index(contact.seen_at)];
    if (!cluster.closes) continue;
    const Way taken = way(cluster);
    ordered_[(taken == here ? 0 : end_of_[taken - 1]) + index(cluster.at++)] = contact;
  }
}

void ContactSolver::solve(double step_s) {
  order_by_cluster();
  const std::span<Contact> all(ordered_);
  for (std::size_t at = 0; at < end_of_[here];) {
    const std::size_t size = index(-clusters_[index(all[at].seen_at)].contacts);
    solve_here(all.subspan(at, size));
    at += size;
    alone_ += size == 1;
  }
  solved_by_ode_ += all.size() - end_of_[here];
  const std::span<Contact> robots = all.subspan(end_of_[here], end_of_[by_ode] - end_of_[here]),
                           objects = all.subspan(end_of_[by_ode]);
  if (!robots.empty()) ode_.solve(robots, {}, points_, places_, bodies_, rounds_, step_s);
  if (!objects.empty() || !sliding_.empty())
    ode_.solve(objects, sliding_, points_, places_, bodies_, std::max(rounds_, least_rounds_with_objects), step_s);
}

void ContactSolver::apply(const Contact& contact, double push_m, double rub_m) {
  ContactBody &a = bodies_[index(contact.a)], &b = bodies_[index(contact.b)];
  // across the normal: to its left
  const double x = push_m * contact.normal_x - rub_m * contact.normal_y,
               y = push_m * contact.normal_y + rub_m * contact.normal_x;
  a.dx -= x;
  a.dy -= y;
  a.roll -= 2 * rub_m;  // a disc's r^2 / I
  if (contact.fixed()) return;
  b.dx += x;
  b.dy += y;
  b.roll -= 2 * rub_m;
}

// Makes one contact hold as if it were the only one: what the impulse equations with friction give at once. Motions of
// this step stand for velocities. Returns by how much it moved a body.
double ContactSolver::relax(Contact& contact) {
  const ContactBody &a = bodies_[index(contact.a)], &b = bodies_[index(contact.b)];
  const double x = a.dx - b.dx, y = a.dy - b.dy;
  const double closing = x * contact.normal_x + y * contact.normal_y, allowed = allowed_m(contact.gap_m);
  const double push = std::max(0.0, contact.push_m + (closing - allowed) * contact.share);
  // sliding at the touching point; a disc's tangential compliance is 1 + r^2 / I = 3
  const double sliding = y * contact.normal_x - x * contact.normal_y + a.roll + b.roll;
  const double most = friction_ * push,
               rub = std::clamp(contact.rub_m + sliding * (static_cast<double>(contact.share) / 3), -most, most);
  const double more_push = push - contact.push_m, more_rub = rub - contact.rub_m;
  contact.push_m = push;
  contact.rub_m = rub;
  apply(contact, more_push, more_rub);
  return std::abs(more_push) + std::abs(more_rub);
}

void ContactSolver::solve_here(std::span<Contact> cluster) {
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
      ContactBody &a = bodies_[index(contact.a)], &b = bodies_[index(contact.b)];
      if (a.moved_at <= contact.seen_at && b.moved_at <= contact.seen_at) continue;
      contact.seen_at = ++now_;
      // Without a branch, for none can be foretold.
      const bool moves = relax(contact) >= solved_m;
      moved |= moves;
      a.moved_at = moves ? now_ : a.moved_at;
      b.moved_at = moves ? now_ : b.moved_at;
    }
    if (!moved) return;
  }
}

}  // namespace arkmesh::sim_ode
