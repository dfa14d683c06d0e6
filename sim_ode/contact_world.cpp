// Everybody moves in one pass over arrays, as if alone; those who touch are then put where the contacts let them go.
// Who may touch is listed for many steps at once.
#include "sim_ode/contact_world.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/fixed_math.hpp"
#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double tick_s = tick_us * 1e-6;
// How near two robots may come to each other in one step. Beyond the larger one a tick is divided into steps: contacts
// hold along their direction at a step's start, which so many millimetres turn by a few degrees at most.
constexpr double least_reach_m = 0.0015, largest_reach_m = 0.002;
// Pairs are listed while nearer than a diameter plus this; the list then serves many steps.
constexpr double skin_m = 0.02;
constexpr std::uint64_t align_ticks = 64;

double within_pi(double angle) {
  while (angle > std::numbers::pi) angle -= 2 * std::numbers::pi;
  while (angle <= -std::numbers::pi) angle += 2 * std::numbers::pi;
  return angle;
}

}  // namespace

ContactWorld::ContactWorld(double width_m, double height_m, const ContactSettings& contacts, std::uint64_t seed,
                           const std::vector<hal::Pose>& start, const hal::Solids& solids)
    : width_m_(width_m),
      height_m_(height_m),
      body_radius_m_(contacts.body_radius_m),
      grid_(width_m, height_m, 2 * body_radius_m_ + skin_m, static_cast<int>(start.size())),
      solids_(width_m, height_m, solids, body_radius_m_),
      solver_(contacts, seed, solids_.objects()),
      reach_m_(least_reach_m) {
  const std::size_t n = start.size();
  for (const hal::Pose& pose : start) {
    now_.x.push_back(pose.x_m);
    now_.y.push_back(pose.y_m);
    now_.heading.push_back(within_pi(pose.heading_rad));
    now_.cos.push_back(hal::fixed::cos(pose.heading_rad));
    now_.sin.push_back(hal::fixed::sin(pose.heading_rad));
  }
  before_ = now_;
  for (std::vector<double>* zeros : {&ahead_, &left_, &turn_, &turn_sin_}) zeros->assign(n, 0);
  turn_cos_.assign(n, 1);
  velocity_.resize(n);
  in_arena_.assign(n, 1);
  body_of_.assign(n, -1);
}

void ContactWorld::set_velocity(int robot, const Velocity& velocity) {
  const std::size_t i = index(robot);
  velocity_[i] = velocity;
  const double step_s = tick_s / steps_per_tick_, turn = velocity.turn_rad_s * step_s;
  const double half_cos = hal::fixed::cos(turn / 2), half_sin = hal::fixed::sin(turn / 2);
  ahead_[i] = step_s * (velocity.ahead_m_s * half_cos - velocity.left_m_s * half_sin);
  left_[i] = step_s * (velocity.ahead_m_s * half_sin + velocity.left_m_s * half_cos);
  turn_[i] = turn;
  turn_cos_[i] = half_cos * half_cos - half_sin * half_sin;
  turn_sin_[i] = 2 * half_cos * half_sin;
  fastest2_ = std::max(fastest2_, ahead_[i] * ahead_[i] + left_[i] * left_[i]);
}

void ContactWorld::place(int robot, const hal::Pose& pose) {
  const std::size_t i = index(robot);
  longest_path_m_ += hal::fixed::hypot(pose.x_m - now_.x[i], pose.y_m - now_.y[i]);
  slack_m_ = -1;  // pairs are listed anew
  for (Places* places : {&now_, &before_, &tick_began_}) {
    if (places->x.empty()) continue;  // no tick was divided yet
    places->x[i] = pose.x_m;
    places->y[i] = pose.y_m;
    places->heading[i] = within_pi(pose.heading_rad);
    places->cos[i] = hal::fixed::cos(pose.heading_rad);
    places->sin[i] = hal::fixed::sin(pose.heading_rad);
  }
  in_arena_[i] = 1;
}

void ContactWorld::take_off(int robot) {
  // beyond anybody's reach, each on a shelf of its own
  place(robot, {10 * width_m_ + 10 + robot, 10 * height_m_ + 10, now_.heading[index(robot)]});
  in_arena_[index(robot)] = 0;
}

void ContactWorld::tick() {
  divide_tick();
  // Before the tick's first place is kept: within it headings stay unwrapped, so that pose() turns the way they turned.
  if (ticks_++ % align_ticks == 0) align_headings();
  if (steps_per_tick_ > 1) tick_began_ = now_;
  solids_.begin_tick();
  for (int step = 0; step < steps_per_tick_; ++step) {
    list_pairs();
    move_alone();
    hold_contacts();
  }
}

// Finds into how many steps the next tick must be divided, and how near robots may come to each other in one.
void ContactWorld::divide_tick() {
  const double nearer_m = 2 * std::sqrt(fastest2_) * steps_per_tick_;
  const int steps = std::max(1, static_cast<int>(std::ceil(nearer_m / largest_reach_m)));
  reach_m_ = std::max(least_reach_m, nearer_m / steps);
  if (steps == steps_per_tick_) return;
  steps_per_tick_ = steps;
  fastest2_ = 0;
  for (int i = 0; i < robots(); ++i) set_velocity(i, velocity_[index(i)]);
}

void ContactWorld::list_pairs() {
  if (slack_m_ < 0) find_pairs();
}

void ContactWorld::hold_contacts() {
  double path = std::sqrt(fastest2_), objects_path = 0;
  find_contacts();
  if (!solver_.empty()) {
    solver_.solve(tick_s / steps_per_tick_);
    if (!solids_.empty()) objects_path = solids_.move(solver_, tick_s / steps_per_tick_);
    correct_touched();
    for (const ContactBody& body : solver_.bodies())
      if (body.robot >= 0) path = std::max(path, std::sqrt(body.dx * body.dx + body.dy * body.dy));
  }
  path = std::max(path, objects_path);
  slack_m_ -= 2 * path;  // two robots may have come nearer by twice the path
  longest_path_m_ += path;
  ++totals_.steps;
}

void ContactWorld::align_headings() {
  fastest2_ = 0;
  for (std::size_t i = 0; i < now_.x.size(); ++i) {
    now_.heading[i] = within_pi(now_.heading[i]);
    now_.cos[i] = hal::fixed::cos(now_.heading[i]);
    now_.sin[i] = hal::fixed::sin(now_.heading[i]);
    fastest2_ = std::max(fastest2_, ahead_[i] * ahead_[i] + left_[i] * left_[i]);
  }
}

// Lists the pairs that may touch while nobody moves by more than half the skin.
void ContactWorld::find_pairs() {
  grid_.build(now_.x, now_.y);
  pairs_.clear();
  walls_.clear();
  grid_.visit_pairs(2 * body_radius_m_ + skin_m, [this](int a, int b) { pairs_.push_back({a, b, 0, 0}); });
  for (int i = 0; i < robots(); ++i) {
    const double x = now_.x[index(i)], y = now_.y[index(i)];
    if (!in_arena_[index(i)]) continue;
    if (width_m_ / 2 - body_radius_m_ - std::abs(x) < skin_m) walls_.push_back({i, x < 0 ? -1 : -2, 0, 0});
    if (height_m_ / 2 - body_radius_m_ - std::abs(y) < skin_m) walls_.push_back({i, y < 0 ? -3 : -4, 0, 0});
  }
  if (!solids_.empty()) solids_.list_near(grid_, now_.x, now_.y, skin_m);
  slack_m_ = skin_m - largest_reach_m - 4 * NeighbourGrid::rounded_m;
}

// How far the robot would go alone.
std::pair<double, double> ContactWorld::motion(int robot) const {
  const std::size_t i = index(robot);
  return {before_.cos[i] * ahead_[i] - before_.sin[i] * left_[i],
          before_.sin[i] * ahead_[i] + before_.cos[i] * left_[i]};
}

void ContactWorld::move_alone() {
  std::swap(now_, before_);
  const std::size_t n = now_.x.size();
  const double *const x0 = before_.x.data(), *const y0 = before_.y.data(), *const h0 = before_.heading.data(),
                      *const c0 = before_.cos.data(), *const s0 = before_.sin.data();
  const double *const ahead = ahead_.data(), *const left = left_.data(), *const turn = turn_.data(),
                      *const tc = turn_cos_.data(), *const ts = turn_sin_.data();
  double* const __restrict x = now_.x.data();
  double* const __restrict y = now_.y.data();
  double* const __restrict h = now_.heading.data();
  double* const __restrict c = now_.cos.data();
  double* const __restrict s = now_.sin.data();
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = x0[i] + (c0[i] * ahead[i] - s0[i] * left[i]);
    y[i] = y0[i] + (s0[i] * ahead[i] + c0[i] * left[i]);
    h[i] = h0[i] + turn[i];
    c[i] = c0[i] * tc[i] - s0[i] * ts[i];
    s[i] = c0[i] * ts[i] + s0[i] * tc[i];
  }
}

int ContactWorld::body(int robot) {
  int& body = body_of_[index(robot)];
  if (body < 0) {
    const auto [dx, dy] = motion(robot);
    body = solver_.add_body(robot, before_.x[index(robot)], before_.y[index(robot)], dx, dy,
                            body_radius_m_ * turn_[index(robot)]);
  }
  return body;
}

void ContactWorld::find_contacts() {
  solver_.clear();
  const double near_m = 2 * body_radius_m_ + reach_m_;
  const double *const px = before_.x.data(), *const py = before_.y.data();
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    Pair& pair = pairs_[k];
    const double x = px[pair.b] - px[pair.a], y = py[pair.b] - py[pair.a], d2 = x * x + y * y;
    if (d2 >= near_m * near_m) continue;
    const double d = std::max(std::sqrt(d2), 1e-9), nx = x / d, ny = y / d, gap = d - 2 * body_radius_m_;
    const int a = body(pair.a), b = body(pair.b);
    const auto &one = solver_.bodies()[index(a)], &other = solver_.bodies()[index(b)];
    const bool closes = (one.dx - other.dx) * nx + (one.dy - other.dy) * ny > gap;
    solver_.add(a, b, nx, ny, gap, closes, pair.push_m, pair.rub_m, static_cast<int>(k));
    pair.push_m = pair.rub_m = 0;
  }

  const double free_x = width_m_ / 2 - body_radius_m_, free_y = height_m_ / 2 - body_radius_m_;
  for (std::size_t k = 0; k < walls_.size(); ++k) {
    Pair& wall = walls_[k];
    const double nx = wall.b == -1 ? -1 : wall.b == -2 ? 1 : 0, ny = wall.b == -3 ? -1 : wall.b == -4 ? 1 : 0;
    const double gap = nx != 0 ? free_x - nx * px[wall.a] : free_y - ny * py[wall.a];
    if (gap >= reach_m_) continue;
    const int a = body(wall.a);
    const auto& one = solver_.bodies()[index(a)];
    solver_.add_wall(a, nx, ny, gap, one.dx * nx + one.dy * ny > gap, wall.push_m, wall.rub_m,
                     -1 - static_cast<int>(k));
    wall.push_m = wall.rub_m = 0;
  }
  if (!solids_.empty())
    solids_.find_contacts(before_.x, before_.y, reach_m_, tick_s / steps_per_tick_, solver_,
                          [this](int robot) { return body(robot); });
}

// Puts those in contact where the contacts let them go, and looks how deep they ended.
void ContactWorld::correct_touched() {
  for (int k = 0; k < static_cast<int>(solver_.bodies().size()); ++k) {
    const ContactBody& body = solver_.bodies()[index(k)];
    if (body.robot < 0) continue;
    const std::size_t i = index(body.robot);
    body_of_[i] = -1;
    if (!solver_.in_contact(k)) continue;
    ++totals_.touching;
    now_.x[i] = before_.x[i] + body.dx;
    now_.y[i] = before_.y[i] + body.dy;
    const double turned = body.roll / body_radius_m_;
    now_.heading[i] = before_.heading[i] + turned;
    // a third of a radian at most: the next terms are below 1e-9
    const double t2 = turned * turned, c = 1 - t2 / 2 * (1 - t2 / 12 * (1 - t2 / 30)),
                 s = turned * (1 - t2 / 6 * (1 - t2 / 20 * (1 - t2 / 42)));
    now_.cos[i] = before_.cos[i] * c - before_.sin[i] * s;
    now_.sin[i] = before_.cos[i] * s + before_.sin[i] * c;
  }

  const auto& bodies = solver_.bodies();
  for (const Contact& contact : solver_.solved()) {
    if (contact.of_solid) continue;
    Pair& pair = contact.fixed() ? walls_[index(-1 - contact.source)] : pairs_[index(contact.source)];
    pair.push_m = static_cast<float>(contact.push_m);
    pair.rub_m = static_cast<float>(contact.rub_m);
    const std::size_t a = index(bodies[index(contact.a)].robot);
    double deep;
    if (contact.fixed()) {
      deep = contact.normal_x != 0 ? std::abs(now_.x[a]) + body_radius_m_ - width_m_ / 2
                                   : std::abs(now_.y[a]) + body_radius_m_ - height_m_ / 2;
    } else {
      const std::size_t b = index(bodies[index(contact.b)].robot);
      const double x = now_.x[b] - now_.x[a], y = now_.y[b] - now_.y[a], touching_m = 2 * body_radius_m_;
      deep = touching_m - std::sqrt(x * x + y * y);
    }
    totals_.deepest_m = std::max(totals_.deepest_m, deep);
    totals_.deep += deep > 0.001;
  }
  if (!solids_.empty()) {
    const SolidBodies::Depth depth = solids_.depth(solver_, now_.x, now_.y);
    totals_.deepest_m = std::max(totals_.deepest_m, depth.deepest_m);
    totals_.deep += static_cast<std::uint64_t>(depth.deeper_than_1mm);
  }
  totals_.contacts += solver_.solved().size();
  totals_.ode_steps = solver_.ode_steps();
  totals_.by_ode = solver_.solved_by_ode();
  totals_.alone = solver_.alone();
  totals_.drift_m = solver_.drift_m();
}

hal::Pose ContactWorld::pose(int robot, double share) const {
  const std::size_t i = index(robot);
  const auto between = [share](double from, double to) { return from + share * (to - from); };
  const Places& from = steps_per_tick_ > 1 ? tick_began_ : before_;
  return {between(from.x[i], now_.x[i]), between(from.y[i], now_.y[i]),
          within_pi(between(from.heading[i], now_.heading[i]))};
}

}  // namespace arkmesh::sim_ode
