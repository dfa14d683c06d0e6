// What a piece of the kit is to a scenario in Python, and the pieces that sense robots, walls and places. For
// kit_pieces.cpp.
#pragma once

#include <fmt/format.h>

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "scenarios/kit/bearing.hpp"
#include "scenarios/kit/neighbours.hpp"
#include "scenarios/kit/others.hpp"
#include "scenarios/kit/readings.hpp"
#include "scenarios/kit/sectors.hpp"
#include "scenarios/python/kit_pieces.hpp"

namespace arkmesh::scenarios::python {

using Column = kit::Readings::Column;

struct KitPieces::Piece {
  virtual ~Piece() = default;
  virtual std::size_t columns() const = 0;
  // Appends columns() numbers for each robot of the frame.
  virtual void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) = 0;
  virtual std::vector<double> world() const { return {}; }
  virtual void act(lab::Lab&, const hal::PoseFrame&, const Said&) {}
  virtual void end_frame(lab::Lab&) {}
  virtual void on_period(lab::Lab&) {}

  // Where readings are renewed now and then and have noise; `columns` have theirs.
  void make_imperfect(const lab::Lab& lab, const Said& asked, std::vector<Column> columns) {
    readings.emplace(asked.at("every"), std::move(columns), lab.seed(),
                     fmt::format("{}/kit/{}", lab.name(), asked.at("number").get<int>()));
  }
  std::optional<kit::Readings> readings;
};

// Distances in each sector; -1: nothing is within reach.
struct KitPieces::Eyes final : Piece {
  Eyes(const lab::Lab& lab, const Said& asked)
      : sectors({.count = asked.at("sectors"),
                 .around = asked.at("around"),
                 .reach_m = asked.at("reach"),
                 .half_planes = asked.at("half_planes")}),
        walls(lab.arena().width_m, lab.arena().height_m, lab.arena().obstacles, asked.at("margin")),
        what(walls) {
    if (!asked.at("robots").is_null()) radius_m = asked.at("robots");
    make_imperfect(lab, asked, std::vector<Column>(columns(), {.high = asked.at("reach"), .noise = asked.at("noise")}));
  }

  std::size_t columns() const override { return static_cast<std::size_t>(sectors.count()); }
  void sense(const lab::Lab&, const hal::PoseFrame& frame, std::vector<double>& out) override {
    for (const hal::Observation& robot : frame.robots)
      for (const double d : sectors.distances_m(robot.pose, what)) out.push_back(d < 1e9 ? d : -1);
  }
  void on_period(lab::Lab& lab) override {
    const auto discs = radius_m ? kit::discs_around(kit::others_in(lab), *radius_m) : kit::no_walk_zones(lab);
    what = walls;
    what.add_discs(discs);
  }

  kit::Sectors sectors;
  kit::Surroundings walls, what;   // all that is seen: walls, and robots as merged last
  std::optional<double> radius_m;  // of robots of other labs, as discs; without it they are what sensors.presence says
};

inline kit::LedSet leds_in(const nlohmann::ordered_json& asked) {
  kit::LedSet out = 0;
  for (const auto& led : asked.at("leds")) out = static_cast<kit::LedSet>(out | 1U << led.get<unsigned>());
  return out;
}

struct KitPieces::Crowd final : Piece {
  Crowd(const lab::Lab& lab, const Said& asked)
      : range_m(asked.at("range")), of_all_labs(asked.at("others")), leds(leds_in(asked)) {
    make_imperfect(lab, asked, {{Column::Kind::whole_number, 0, 1e6, asked.at("noise")}});
    kit::neighbours({}, {}, range_m);  // what is wrong is said at once
  }

  std::size_t columns() const override { return 1; }
  void sense(const lab::Lab&, const hal::PoseFrame& frame, std::vector<double>& out) override {
    std::vector<kit::Seen> all;
    for (const hal::Observation& robot : frame.robots) all.push_back({{robot.pose.x_m, robot.pose.y_m}, robot.led});
    const std::size_t own = all.size();
    all.insert(all.end(), others.begin(), others.end());
    for (const int n : kit::neighbours(std::span(all).first(own), all, range_m, leds)) out.push_back(n);
  }

  void on_period(lab::Lab& lab) override {
    if (of_all_labs) others = kit::others_in(lab);
  }

  double range_m;
  bool of_all_labs;
  kit::LedSet leds;
  std::vector<kit::Seen> others;  // of other labs, as merged last
};

struct KitPieces::Towards final : Piece {
  Towards(const lab::Lab& lab, const Said& asked) : place{asked.at("x"), asked.at("y")} {
    const Said& noise = asked.at("noise");
    make_imperfect(lab, asked, {{Column::Kind::angle, 0, 0, noise.at(0)}, {Column::Kind::number, 0, 1e9, noise.at(1)}});
  }

  std::size_t columns() const override { return 2; }
  void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) override {
    for (const hal::Observation& robot : frame.robots) {
      const hal::Pose at = lab.projection().to_shared(robot.pose);
      out.push_back(kit::bearing_rad(at, place));
      out.push_back(kit::distance_m(at, place));
    }
  }

  hal::Point place;
};

// Where robots are in the shared world: x, y, heading.
struct KitPieces::Gps final : Piece {
  Gps(const lab::Lab& lab, const Said& asked) {
    const Said& noise = asked.at("noise");
    const Column place{Column::Kind::number, -1e9, 1e9, noise.at(0)};
    make_imperfect(lab, asked, {place, place, {Column::Kind::angle, 0, 0, noise.at(1)}});
  }

  std::size_t columns() const override { return 3; }
  void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) override {
    for (const hal::Observation& robot : frame.robots) {
      const hal::Pose at = lab.projection().to_shared(robot.pose);
      out.insert(out.end(), {at.x_m, at.y_m, at.heading_rad});
    }
  }
};

}  // namespace arkmesh::scenarios::python
