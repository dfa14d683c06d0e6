#include "scenarios/python/kit_pieces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <stdexcept>
#include <utility>

#include "scenarios/kit/neighbours.hpp"
#include "scenarios/kit/sectors.hpp"
#include "scenarios/kit/shared_pheromone.hpp"
#include "scenarios/python/encoding.hpp"

namespace arkmesh::scenarios::python {
namespace {

// Robots of other labs, where they are in this arena.
std::vector<kit::Seen> others_in(const lab::Lab& lab) {
  std::vector<kit::Seen> out;
  for (const std::string& each : lab.labs()) {
    if (each == lab.name()) continue;
    for (const lab::SharedRobot& robot : lab.state(each).robots) {
      const hal::Pose at = lab.projection().to_arena(robot.in_shared);
      out.push_back({{at.x_m, at.y_m}, robot.led});
    }
  }
  return out;
}

}  // namespace

struct KitPieces::Piece {
  virtual ~Piece() = default;
  virtual std::size_t columns() const = 0;
  // Appends columns() numbers for each robot of the frame.
  virtual void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) = 0;
  virtual void act(lab::Lab&, const hal::PoseFrame&, const Said&) {}
  virtual void end_frame(lab::Lab&) {}
  virtual void on_period(lab::Lab&) {}
};

// Distances in each sector; -1: nothing is within reach.
struct KitPieces::Eyes final : Piece {
  Eyes(const lab::Lab& lab, const Said& asked)
      : sectors({.count = asked.at("sectors"), .around = asked.at("around"), .reach_m = asked.at("reach")}),
        walls(lab.arena().width_m, lab.arena().height_m, lab.arena().obstacles),
        radius_m(asked.at("robots")) {}

  std::size_t columns() const override { return static_cast<std::size_t>(sectors.count()); }
  void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) override {
    kit::Surroundings what = walls;
    if (radius_m > 0) {
      std::vector<kit::Surroundings::Disc> discs;
      for (const kit::Seen& other : others_in(lab)) discs.push_back({other.place, radius_m});
      what.add_discs(discs);
    }
    for (const hal::Observation& robot : frame.robots)
      for (const double d : sectors.distances_m(robot.pose, what)) out.push_back(d < 1e9 ? d : -1);
  }

  kit::Sectors sectors;
  kit::Surroundings walls;
  double radius_m;  // of robots of other labs, as discs; 0: they are not seen
};

struct KitPieces::Crowd final : Piece {
  explicit Crowd(const Said& asked) : range_m(asked.at("range")), others(asked.at("others")) {
    for (const auto& led : asked.at("leds")) leds = static_cast<kit::LedSet>(leds | 1U << led.get<unsigned>());
    kit::neighbours({}, {}, range_m);  // what is wrong is said at once
  }

  std::size_t columns() const override { return 1; }
  void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) override {
    std::vector<kit::Seen> all;
    for (const hal::Observation& robot : frame.robots) all.push_back({{robot.pose.x_m, robot.pose.y_m}, robot.led});
    const std::size_t own = all.size();
    if (others) std::ranges::move(others_in(lab), std::back_inserter(all));
    for (const int n : kit::neighbours(std::span(all).first(own), all, range_m, leds)) out.push_back(n);
  }

  double range_m;
  bool others;
  kit::LedSet leds = 0;
};

// Value, slope along x and y of the arena, and zones.
struct KitPieces::Trail final : Piece {
  Trail(lab::Lab& lab, const Said& asked)
      : trail(asked.at("name"), {.width_m = asked.at("width"),
                                 .height_m = asked.at("height"),
                                 .cell_m = asked.at("cell"),
                                 .half_life_s = asked.at("half_life"),
                                 .linear_per_s = asked.at("linear"),
                                 .diffusion_m2_s = asked.at("diffusion"),
                                 .wind_x_m_s = asked.at("wind").at(0),
                                 .wind_y_m_s = asked.at("wind").at(1),
                                 .cap = asked.at("cap"),
                                 .cut_off = asked.at("cut_off")}),
        full(asked.at("full")) {
    if (const Said& zones = asked.at("zones"); !zones.is_null()) {
      count = zones.at(0);
      opening_rad = zones.at(1);
      radius_m = zones.at(2);
      least = zones.at(3);
      trail.field().zones({}, count, opening_rad, radius_m, least);  // what is wrong is said at once
    }
    trail.begin(lab);
  }

  std::size_t columns() const override { return 4; }
  void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) override {
    const hal::Projection& projection = lab.projection();
    const hal::Projection turned{.turn_rad = projection.turn_rad};
    for (const hal::Observation& robot : frame.robots) {
      const hal::Pose at = trail.in_field(lab, robot.pose);
      const hal::Point place{at.x_m, at.y_m}, slope = trail.field().gradient(place);
      const hal::Pose in_arena = turned.to_arena({slope.x_m, slope.y_m, 0});
      out.push_back(trail.field().at(place));
      out.push_back(in_arena.x_m * projection.scale);
      out.push_back(in_arena.y_m * projection.scale);
      out.push_back(count == 0 ? 0 : trail.field().zones(at, count, opening_rad, radius_m, least));
    }
  }
  void act(lab::Lab& lab, const hal::PoseFrame& frame, const Said& done) override {
    const Said &robots = done.at("robots"), &amounts = done.at("amounts");
    std::map<hal::RobotId, double> laid;
    for (std::size_t i = 0; i < robots.size(); ++i) laid[robots.at(i)] += amounts.at(i).get<double>();
    for (const hal::Observation& robot : frame.robots)
      if (const auto found = laid.find(robot.robot); found != laid.end()) trail.lay(lab, robot.pose, found->second);
  }
  void end_frame(lab::Lab& lab) override { trail.tell(lab); }
  void on_period(lab::Lab& lab) override {
    trail.on_period(lab);
    if (full > 0) trail.field().draw(lab, lab.projection(), full);
  }

  kit::SharedPheromone trail;
  double full;  // drawn darkest; 0: not drawn
  int count = 0;
  double opening_rad = 0, radius_m = 0, least = 0;  // radius in the shared frame
};

KitPieces::KitPieces() = default;
KitPieces::~KitPieces() = default;

void KitPieces::add(lab::Lab& lab, const Said& asked) {
  const std::string piece = asked.at("piece");
  if (piece == "eyes")
    pieces_.push_back(std::make_unique<Eyes>(lab, asked));
  else if (piece == "crowd")
    pieces_.push_back(std::make_unique<Crowd>(asked));
  else
    pieces_.push_back(std::make_unique<Trail>(lab, asked));
}

std::string KitPieces::sense(const lab::Lab& lab, const hal::PoseFrame& frame) {
  std::string out;
  if (pieces_.empty()) return out;
  frame_ = frame;
  std::vector<double> sensed;
  for (const auto& piece : pieces_) {
    sensed.clear();
    piece->sense(lab, frame, sensed);
    put(out, static_cast<std::uint32_t>(piece->columns()));
    for (const double number : sensed) put(out, number);
  }
  return out;
}

void KitPieces::act(lab::Lab& lab, const Said& done) {
  pieces_.at(done.at("piece").get<std::size_t>())->act(lab, frame_, done);
}

void KitPieces::end_frame(lab::Lab& lab) {
  for (const auto& piece : pieces_) piece->end_frame(lab);
}

void KitPieces::on_period(lab::Lab& lab) {
  for (const auto& piece : pieces_) piece->on_period(lab);
}

}  // namespace arkmesh::scenarios::python
