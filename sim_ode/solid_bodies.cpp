#include "sim_ode/solid_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/fixed_math.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double gravity_m_s2 = 9.81;
constexpr double skin_of_dents_m = 1e-5;

}  // namespace

SolidBodies::SolidBodies(double width_m, double height_m, const hal::Solids& solids, double robot_radius_m)
    : width_m_(width_m), height_m_(height_m), robot_radius_m_(robot_radius_m) {
  const auto add = [this](const hal::Shape& shape, const hal::Pose& pose, bool moves) -> Thing& {
    hal::Shape about_centre = shape;
    const hal::Point centre = Outline(shape).centre();
    for (hal::Point& corner : about_centre.corners) corner = {corner.x_m - centre.x_m, corner.y_m - centre.y_m};
    const double c = hal::fixed::cos(pose.heading_rad), s = hal::fixed::sin(pose.heading_rad);
    Thing thing{.outline = Outline(about_centre),
                .moves = moves,
                .x = pose.x_m + c * centre.x_m - s * centre.y_m,
                .y = pose.y_m + s * centre.x_m + c * centre.y_m,
                .heading = pose.heading_rad,
                .cos = c,
                .sin = s,
                .own_origin = {-centre.x_m, -centre.y_m}};
    return things_.emplace_back(std::move(thing));
  };
  for (const hal::Obstacle& obstacle : solids.obstacles) add(obstacle.shape, obstacle.pose, false);
  first_object_ = static_cast<int>(things_.size());
  if (!solids.rim.empty()) floor_.emplace(hal::Shape{.corners = solids.rim});
  rim_end_ = first_object_;
  rim_begin_ = floor_ && floor_->is_convex() ? rim_end_ - static_cast<int>(solids.rim.size()) : rim_end_;
  for (const hal::MovableObject& object : solids.objects) {
    Thing& thing = add(object.shape, object.start, true);
    const double held_n = object.friction * object.mass_kg * gravity_m_s2;
    thing.body = {object.mass_kg, object.mass_kg * thing.outline.gyration_m2(), held_n,
                  held_n * thing.outline.mean_distance_m()};
  }
  begin_tick();
}

std::vector<ObjectBody> SolidBodies::objects() const {
  std::vector<ObjectBody> out;
  for (const Thing& thing : things_)
    if (thing.moves) out.push_back(thing.body);
  return out;
}

void SolidBodies::shade(Shadows& out) const {
  out.blockers.clear();
  for (int k = 0; k < static_cast<int>(things_.size()); ++k) {
    if (k >= rim_begin_ && k < rim_end_) continue;
    const Thing& thing = things_[index(k)];
    const PlacedOutline here = placed(thing);
    if (thing.outline.is_disc()) {
      out.blockers.push_back(Blocker::disc({thing.x, thing.y}, thing.outline.shape().radius_m));
      continue;
    }
    std::vector<Point> corners;
    for (std::size_t i = 0; i < here.corners(); ++i) corners.push_back(here.corner(i));
    if (thing.outline.is_convex()) {
      out.blockers.push_back(Blocker::polygon(std::move(corners)));
      continue;
    }
    // light comes from outside, so that a thin skin is as good as the whole
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
      const double x = b.x_m - a.x_m, y = b.y_m - a.y_m, length = std::sqrt(x * x + y * y);
      if (length == 0) continue;
      const double in_x = -y / length * skin_of_dents_m, in_y = x / length * skin_of_dents_m;
      out.blockers.push_back(Blocker::polygon({a, b, {b.x_m + in_x, b.y_m + in_y}, {a.x_m + in_x, a.y_m + in_y}}));
    }
  }
}

void SolidBodies::list_near(const NeighbourGrid& robots, std::span<const double> x, std::span<const double> y,
                            double skin_m) {
  near_.clear();
  near_things_.clear();
  for (int i = 0; i < static_cast<int>(things_.size()); ++i) {
    const Thing& thing = things_[index(i)];
    const PlacedOutline here = placed(thing);
    const double far_m = robot_radius_m_ + skin_m;
    robots.visit_near(thing.x, thing.y, thing.outline.bound_m() + far_m, [&](const NeighbourGrid::Member& robot) {
      if (here.distance_m(x[index(robot.number)], y[index(robot.number)]) < far_m) near_.push_back({robot.number, i});
    });
    if (!thing.moves) continue;
    const double free_x = width_m_ / 2 - thing.outline.bound_m() - skin_m,
                 free_y = height_m_ / 2 - thing.outline.bound_m() - skin_m;
    if (std::abs(thing.x) > free_x) near_things_.push_back({i, thing.x < 0 ? -1 : -2});
    if (std::abs(thing.y) > free_y) near_things_.push_back({i, thing.y < 0 ? -3 : -4});
    // a thing wider than the arena's half meets both sides
    if (thing.outline.bound_m() + skin_m > width_m_ / 4) near_things_.push_back({i, thing.x < 0 ? -2 : -1});
    if (thing.outline.bound_m() + skin_m > height_m_ / 4) near_things_.push_back({i, thing.y < 0 ? -4 : -3});
    for (int j = 0; j < i; ++j) {
      const Thing& other = things_[index(j)];
      const double reach = thing.outline.bound_m() + other.outline.bound_m() + skin_m, dx = other.x - thing.x,
                   dy = other.y - thing.y;
      if (dx * dx + dy * dy < reach * reach) near_things_.push_back({i, j});
    }
  }
}

int SolidBodies::body(int thing, ContactSolver& solver, double step_s) {
  int& out = body_of_[index(thing)];
  const Thing& one = things_[index(thing)];
  if (out < 0)
    out = solver.add_body(-2 - (thing - first_object_), one.x, one.y, one.vx * step_s, one.vy * step_s,
                          one.spin * step_s * robot_radius_m_);
  return out;
}

// As an outline's touches, of the wall with the object: normals point into the arena.
void SolidBodies::wall_touches(const Thing& object, int wall, double reach_m, std::vector<Outline::Touch>& out) const {
  const double nx = wall == -1 ? 1 : wall == -2 ? -1 : 0, ny = wall == -3 ? 1 : wall == -4 ? -1 : 0;
  const double half = nx != 0 ? width_m_ / 2 : height_m_ / 2;
  const auto add = [&](double x, double y, double radius) {
    const double gap = half + nx * x + ny * y - radius;
    if (gap < reach_m) out.push_back({gap, nx, ny, x - nx * (gap + radius), y - ny * (gap + radius)});
  };
  if (object.outline.is_disc()) return add(object.x, object.y, object.outline.shape().radius_m);
  const PlacedOutline here = placed(object);
  for (std::size_t i = 0; i < here.corners(); ++i) add(here.corner(i).x_m, here.corner(i).y_m, 0);
}

void SolidBodies::find_object_contacts(double reach_m, double step_s, ContactSolver& solver) {
  // an object's corner may go further than the robots that turn it
  const double far_m = 2 * reach_m;
  for (const NearThings& near : near_things_) {
    const Thing& object = things_[index(near.object)];
    const Thing* const other = near.other >= 0 ? &things_[index(near.other)] : nullptr;
    touches_.clear();
    if (!other)
      wall_touches(object, near.other, far_m, touches_);
    else
      touches_of(placed(object), placed(*other), far_m, touches_);
    for (const Outline::Touch& touch : touches_) {
      const int a = body(near.object, solver, step_s),
                b = other && other->moves ? body(near.other, solver, step_s) : -1;
      solver.add_object(a, b, -touch.normal_x, -touch.normal_y, touch.gap_m, {touch.x, touch.y});
      touched_.push_back({a, -1, near.object, near.other});
    }
  }
}

double SolidBodies::move(ContactSolver& solver, double step_s) {
  double path = 0;
  for (int i = first_object_; i < static_cast<int>(things_.size()); ++i) {
    if (body_of_.empty() || body_of_[index(i)] < 0 || !solver.in_contact(body_of_[index(i)])) continue;
    const ContactBody& solved = solver.bodies()[index(body_of_[index(i)])];
    Thing& thing = things_[index(i)];
    const double turn = solved.roll / robot_radius_m_;
    thing.x += solved.dx;
    thing.y += solved.dy;
    thing.heading = std::remainder(thing.heading + turn, 2 * std::numbers::pi);
    thing.cos = hal::fixed::cos(thing.heading);
    thing.sin = hal::fixed::sin(thing.heading);
    thing.vx = solved.dx / step_s;
    thing.vy = solved.dy / step_s;
    thing.spin = turn / step_s;
    path = std::max(
        path, std::sqrt(solved.dx * solved.dx + solved.dy * solved.dy) + std::abs(turn) * thing.outline.bound_m());
  }
  return path;
}

SolidBodies::Depth SolidBodies::depth(ContactSolver& solver, std::span<const double> x,
                                      std::span<const double> y) const {
  Depth out;
  for (const Touched& touched : touched_) {
    if (!solver.in_contact(touched.a_body)) continue;
    touches_.clear();
    if (touched.robot >= 0)
      placed(things_[index(touched.other)])
          .touches(x[index(touched.robot)], y[index(touched.robot)], robot_radius_m_, 0, touches_);
    else if (touched.other < 0)
      wall_touches(things_[index(touched.object)], touched.other, 0, touches_);
    else
      touches_of(placed(things_[index(touched.object)]), placed(things_[index(touched.other)]), 0, touches_);
    double deep = 0;
    for (const Outline::Touch& touch : touches_) deep = std::max(deep, -touch.gap_m);
    out.deepest_m = std::max(out.deepest_m, deep);
    out.deeper_than_1mm += deep > 0.001;
  }
  return out;
}

void SolidBodies::begin_tick() {
  for (Thing& thing : things_) {
    thing.began_x = thing.x;
    thing.began_y = thing.y;
    thing.began_heading = thing.heading;
  }
}

void SolidBodies::poses(double share, std::vector<hal::ObjectObservation>& out) const {
  for (const Thing& thing : things_) {
    if (!thing.moves) continue;
    const double turned = std::remainder(thing.heading - thing.began_heading, 2 * std::numbers::pi),
                 heading = std::remainder(thing.began_heading + share * turned, 2 * std::numbers::pi),
                 c = hal::fixed::cos(heading), s = hal::fixed::sin(heading),
                 x = thing.began_x + share * (thing.x - thing.began_x),
                 y = thing.began_y + share * (thing.y - thing.began_y);
    out.push_back({.pose = {x + c * thing.own_origin.x_m - s * thing.own_origin.y_m,
                            y + s * thing.own_origin.x_m + c * thing.own_origin.y_m, heading}});
  }
}

double SolidBodies::clearance_m(double x, double y, double at_most_m) const {
  double out = floor_ ? std::min(at_most_m, -floor_->distance_m(x, y)) : at_most_m;
  for (const Thing& thing : things_) {
    const double dx = x - thing.x, dy = y - thing.y, far_m = thing.outline.bound_m() + out;
    if (far_m > 0 && dx * dx + dy * dy < far_m * far_m) out = std::min(out, placed(thing).distance_m(x, y));
  }
  return out;
}

std::string SolidBodies::misplaced() const {
  for (int i = first_object_; i < static_cast<int>(things_.size()); ++i) {
    const Thing& object = things_[index(i)];
    touches_.clear();
    for (const int wall : {-1, -2, -3, -4}) wall_touches(object, wall, 0, touches_);
    if (!touches_.empty() || (floor_ && floor_->distance_m(object.x, object.y) > 0))
      return fmt::format("object {} is not completely inside the walls", i - first_object_);
    for (int j = 0; j < i; ++j) {
      touches_.clear();
      touches_of(placed(object), placed(things_[index(j)]), 0, touches_);
      if (!touches_.empty())
        return j < first_object_ ? fmt::format("object {} overlaps obstacle {}", i - first_object_, j)
                                 : fmt::format("objects {} and {} overlap", j - first_object_, i - first_object_);
    }
  }
  return {};
}

}  // namespace arkmesh::sim_ode
