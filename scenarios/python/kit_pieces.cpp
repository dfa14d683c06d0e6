#include "scenarios/python/kit_pieces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "hal/overlay/colour.hpp"
#include "scenarios/kit/floor_map.hpp"
#include "scenarios/kit/light.hpp"
#include "scenarios/kit/region.hpp"
#include "scenarios/kit/resource.hpp"
#include "scenarios/kit/shared_pheromone.hpp"
#include "scenarios/kit/voices.hpp"
#include "scenarios/python/encoding.hpp"
#include "scenarios/python/kit_senses.hpp"

namespace arkmesh::scenarios::python {
namespace {

hal::Point point_of(const nlohmann::ordered_json& pair) {
  return {pair.at(0), pair.at(1)};
}

}  // namespace

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

// Whether a robot is inside; of the region how many robots of all labs that count are, what is left of a resource
// there, and what each of them got since the last boundary. The resource is used and grows at boundaries (Lab::grow).
struct KitPieces::Zone final : Piece {
  Zone(const Said& asked, std::size_t number)
      : name(fmt::format("kit.{}", number)),
        region(region_of(asked)),
        leds(leds_in(asked)),
        label(asked.at("label")),
        colour(colour_named(asked.at("colour"))) {
    if (const Said& given = asked.at("resource"); !given.is_null())
      stock.emplace(kit::Resource::Settings{.capacity = given.at("capacity"),
                                            .growth_per_s = given.at("growth"),
                                            .rate_per_s = given.at("rate"),
                                            .use = given.at("pairs").get<bool>()    ? kit::Resource::Use::by_pairs
                                                   : given.at("shared").get<bool>() ? kit::Resource::Use::shared
                                                                                    : kit::Resource::Use::by_each,
                                            .regrows_at_once_below = given.at("regrows_below")});
  }
  static kit::Region region_of(const Said& asked) {
    std::vector<hal::Point> corners;
    for (const auto& corner : asked.at("corners")) corners.push_back(point_of(corner));
    return asked.at("radius").is_null() ? kit::Region::polygon(std::move(corners))
                                        : kit::Region::disc(corners.at(0), asked.at("radius"));
  }

  std::size_t columns() const override { return 1; }
  void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) override {
    for (const hal::Observation& robot : frame.robots) {
      const hal::Pose at = lab.projection().to_shared(robot.pose);
      out.push_back(region.contains({at.x_m, at.y_m}));
    }
  }
  std::vector<double> world() const override {
    return {static_cast<double>(robots), stock ? stock->stock() : 0.0, share};
  }
  void on_period(lab::Lab& lab) override {
    robots = 0;
    for (const std::string& each : lab.labs())
      for (const lab::SharedRobot& robot : lab.state(each).robots)
        robots += (leds & kit::only(robot.led)) != 0 && region.contains({robot.in_shared.x_m, robot.in_shared.y_m});
    if (stock) use(lab);
    region.seen_in(lab.projection())
        .draw(lab, colour, false, stock ? fmt::format("{} {:.2f}", label, stock->stock()) : label);
  }

  void use(lab::Lab& lab) {
    share = 0;
    for (const lab::Grown& one :
         lab.grow(name, robots > 0 ? std::vector<std::int64_t>{robots} : std::vector<std::int64_t>{})) {
      const auto on_it =
          static_cast<int>(one.happened.empty() ? 0 : std::clamp<std::int64_t>(one.happened[0], 0, 1'000'000));
      if (one.period > 0)
        share += stock->pass(std::chrono::duration<double>(lab.period_length()).count(), on_it) / std::max(1, on_it);
    }
  }

  std::string name;  // of what grows
  kit::Region region;
  kit::LedSet leds;  // of robots that count
  std::string label;
  hal::Colour colour;
  std::optional<kit::Resource> stock;
  int robots = 0;
  double share = 0;
};

struct KitPieces::Tiles final : Piece {
  Tiles(const lab::Lab& lab, const Said& asked)
      : full(static_cast<std::uint8_t>(std::min<std::size_t>(asked.at("shares").size(), 256) - 1)),
        floor(drawn(asked, lab.seed())) {
    make_imperfect(lab, asked, {{Column::Kind::whole_number, 0, static_cast<double>(full), asked.at("noise")}});
  }
  static kit::FloorMap drawn(const Said& asked, std::uint64_t seed) {
    const kit::FloorMap::Size size{.width_m = asked.at("width"),
                                   .height_m = asked.at("height"),
                                   .columns = asked.at("columns"),
                                   .rows = asked.at("rows")};
    if (const Said& given = asked.at("tiles"); !given.is_null()) return {size, given.get<std::vector<std::uint8_t>>()};
    hal::RandomStream random(seed, "kit/" + asked.at("name").get<std::string>());
    return kit::FloorMap::drawn(size, asked.at("shares").get<std::vector<double>>(), asked.at("patch"), random);
  }

  std::size_t columns() const override { return 1; }
  void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) override {
    for (const hal::Observation& robot : frame.robots) {
      const hal::Pose at = lab.projection().to_shared(robot.pose);
      out.push_back(floor.at({at.x_m, at.y_m}));
    }
  }
  void on_period(lab::Lab& lab) override { floor.draw(lab, lab.projection(), full); }

  std::uint8_t full;
  kit::FloorMap floor;
};

struct KitPieces::Talk final : Piece {
  Talk(lab::Lab& lab, const Said& asked) : voices(made(asked)), values(asked.at("values")) { voices.begin(lab); }
  static kit::Voices made(const Said& asked) {
    if (!asked.at("range").is_null()) return {asked.at("name"), asked.at("values"), asked.at("range").get<double>()};
    std::vector<std::pair<kit::Voices::Robot, kit::Voices::Robot>> graph;
    for (const auto& pair : asked.at("graph"))
      graph.emplace_back(kit::Voices::Robot{pair.at(0).at(0), pair.at(0).at(1)},
                         kit::Voices::Robot{pair.at(1).at(0), pair.at(1).at(1)});
    return {asked.at("name"), asked.at("values"), graph};
  }

  std::size_t columns() const override { return values; }
  void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) override {
    for (const int n : voices.heard(lab, frame)) out.push_back(n);
  }
  void act(lab::Lab&, const hal::PoseFrame&, const Said& done) override {
    const Said &robots = done.at("robots"), &said = done.at("values");
    for (std::size_t i = 0; i < robots.size(); ++i) voices.say(robots.at(i), said.at(i));
  }
  void end_frame(lab::Lab& lab) override { voices.tell(lab); }
  void on_period(lab::Lab& lab) override { voices.on_period(lab); }

  kit::Voices voices;
  std::size_t values;
};

struct KitPieces::Shine final : Piece {
  Shine(const lab::Lab& lab, const Said& asked) : light(made(asked)) {
    make_imperfect(lab, asked, {{Column::Kind::whole_number, 0, kit::Light::brightest, asked.at("noise")}});
  }
  static kit::Light made(const Said& asked) {
    kit::Light::Settings settings{.ambient = asked.at("ambient"), .slope_per_m = point_of(asked.at("slope"))};
    for (const auto& given : asked.at("beams")) {
      kit::Light::Beam& beam = settings.beams.emplace_back();
      beam = {.level = given.at("level"), .radius_m = given.at("radius"), .speed_m_s = given.at("speed")};
      for (const auto& place : given.at("path")) beam.path.push_back(point_of(place));
    }
    return kit::Light(std::move(settings));
  }

  std::size_t columns() const override { return 1; }
  void sense(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<double>& out) override {
    for (const hal::Observation& robot : frame.robots) {
      const hal::Pose at = lab.projection().to_shared(robot.pose);
      out.push_back(std::round(light.at({at.x_m, at.y_m}, frame.stamp)));
    }
  }
  void on_period(lab::Lab& lab) override { light.draw(lab, lab.projection()); }

  kit::Light light;
};

KitPieces::KitPieces() = default;
KitPieces::~KitPieces() = default;

void KitPieces::add(lab::Lab& lab, const Said& asked) {
  const std::string piece = asked.at("piece");
  if (piece == "eyes")
    pieces_.push_back(std::make_unique<Eyes>(lab, asked));
  else if (piece == "crowd")
    pieces_.push_back(std::make_unique<Crowd>(lab, asked));
  else if (piece == "region")
    pieces_.push_back(std::make_unique<Zone>(asked, pieces_.size()));
  else if (piece == "floor")
    pieces_.push_back(std::make_unique<Tiles>(lab, asked));
  else if (piece == "towards")
    pieces_.push_back(std::make_unique<Towards>(lab, asked));
  else if (piece == "gps")
    pieces_.push_back(std::make_unique<Gps>(lab, asked));
  else if (piece == "light")
    pieces_.push_back(std::make_unique<Shine>(lab, asked));
  else if (piece == "voices")
    pieces_.push_back(std::make_unique<Talk>(lab, asked));
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
    if (piece->readings) piece->readings->pass(frame, sensed);
    put(out, static_cast<std::uint32_t>(piece->columns()));
    for (const double number : sensed) put(out, number);
  }
  return out;
}

std::string KitPieces::world() const {
  std::string out;
  for (const auto& piece : pieces_) {
    const std::vector<double> numbers = piece->world();
    put(out, static_cast<std::uint32_t>(numbers.size()));
    for (const double number : numbers) put(out, number);
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
