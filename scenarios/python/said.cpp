#include "scenarios/python/said.hpp"

#include <cstring>
#include <stdexcept>
#include <utility>

#include "scenarios/python/encoding.hpp"

namespace arkmesh::scenarios::python {
namespace {

// Pairs of numbers, as bytes.
std::vector<hal::Point> points_in(std::string_view digits) {
  const std::vector<std::uint8_t> bytes = bytes_in(digits);
  std::vector<hal::Point> out(bytes.size() / (2 * sizeof(double)));
  for (std::size_t i = 0; i < out.size(); ++i) {
    std::memcpy(&out[i].x_m, bytes.data() + 2 * i * sizeof(double), sizeof(double));
    std::memcpy(&out[i].y_m, bytes.data() + (2 * i + 1) * sizeof(double), sizeof(double));
  }
  return out;
}

}  // namespace

nlohmann::json setting_in_force(const hal::Section& settings, const nlohmann::json& asked) {
  hal::Field about;
  if (asked.at("low").is_number()) about.range.low = asked.at("low");
  if (asked.at("high").is_number()) about.range.high = asked.at("high");
  about.unit = asked.at("unit");
  about.help = asked.at("help");
  about.one_of = asked.at("one_of").get<std::vector<std::string>>();
  const std::string name = asked.at("name");
  const nlohmann::json& value = asked.at("default");
  if (value.is_boolean()) return settings.get(name, value.get<bool>(), about);
  if (value.is_number_integer()) return settings.get(name, value.get<std::int64_t>(), about);
  if (value.is_number()) return settings.get(name, value.get<double>(), about);
  return settings.get(name, value.get<std::string>(), about);
}

std::vector<std::uint8_t> bytes_in(std::string_view digits) {
  const auto value = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    throw std::runtime_error("returned bytes that are not hexadecimal digits");
  };
  std::vector<std::uint8_t> out(digits.size() / 2);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = static_cast<std::uint8_t>(value(digits[2 * i]) << 4 | value(digits[2 * i + 1]));
  return out;
}

nlohmann::json solid(const hal::Shape& shape, const hal::Pose& at, const std::string& name) {
  nlohmann::json corners = nlohmann::json::array();
  for (const hal::Point& corner : shape.corners) corners.push_back({corner.x_m, corner.y_m});
  return {
      {"name", name},      {"x_m", at.x_m}, {"y_m", at.y_m}, {"heading", at.heading_rad}, {"radius_m", shape.radius_m},
      {"corners", corners}};
}

void draw(lab::Lab& lab, const Said& drawn) {
  std::vector<hal::Point> points = points_in(drawn.at("points").get_ref<const std::string&>());
  const std::string shape = drawn.at("shape"), label = drawn.at("label");
  const hal::Colour colour = colour_named(drawn.at("colour"));
  const bool filled = drawn.at("filled"), dashed = drawn.at("dashed");
  if (shape == "circle")
    for (const hal::Point& at : points) lab.draw(hal::Circle{at, drawn.at("radius"), colour, filled, dashed, label});
  else if (shape == "polygon")
    lab.draw(hal::Polygon{std::move(points), colour, filled, dashed, label});
  else if (shape == "line")
    lab.draw(hal::Line{std::move(points), colour, dashed, label});
  else if (shape == "raster")
    lab.draw(hal::Raster{.corner = {points.at(0).x_m, points.at(0).y_m, drawn.at("heading")},
                         .cell_m = drawn.at("cell_m"),
                         .columns = drawn.at("columns"),
                         .cells = bytes_in(drawn.at("cells").get_ref<const std::string&>()),
                         .colour = colour,
                         .label = label});
  else
    lab.draw(hal::Text{points.at(0), label, colour});
}

std::vector<hal::ToRobot> whole_messages(const Said& given) {
  const Said& robots = given.at("robots");
  std::vector<hal::ToRobot> out(robots.is_null() ? 1 : robots.size(),
                                {.robot = hal::everyone,
                                 .slot = given.at("slot"),
                                 .whole = hal::WholeMessage{given.at("type"), given.at("data")}});
  for (std::size_t i = 0; i < robots.size(); ++i) out[i].robot = robots.at(i);
  return out;
}

}  // namespace arkmesh::scenarios::python
