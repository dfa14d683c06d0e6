#include "scenarios/python/encoding.hpp"

#include <fmt/format.h>

#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

namespace arkmesh::scenarios::python {
namespace {

// `get(robot)` gives id, pose in the arena, pose in the shared frame and LED.
template <class Robots, class Get>
void put_robots(std::string& out, const Robots& robots, const Get& get) {
  out.resize(out.size() + (sizeof(std::uint32_t) - out.size()) % 8);  // wide numbers begin at a multiple of 8
  const std::size_t n = robots.size();
  put(out, static_cast<std::uint32_t>(n));
  std::string ids, places, headings, shared, leds;
  for (const auto& robot : robots) {
    const auto [id, in_arena, in_shared, led] = get(robot);
    put(ids, std::uint32_t{id});
    put(places, in_arena.x_m);
    put(places, in_arena.y_m);
    put(headings, in_arena.heading_rad);
    put(shared, in_shared.x_m);
    put(shared, in_shared.y_m);
    put(leds, static_cast<std::uint8_t>(led));
  }
  // wide numbers first
  for (const std::string* part : {&places, &shared, &headings, &ids, &leds}) out += *part;
}

struct Seen {
  hal::RobotId id;
  hal::Pose in_arena, in_shared;
  hal::Led led;
};

std::size_t size_of_words(std::string_view answer) {
  std::uint32_t size = 0;
  if (answer.size() < sizeof size) throw std::runtime_error("returned an answer that is too short");
  std::memcpy(&size, answer.data(), sizeof size);
  if (size % word_bytes != 0 || answer.size() - sizeof size < size)
    throw std::runtime_error("returned an answer with an incomplete robot message");
  return size;
}

}  // namespace

hal::Colour colour_named(const std::string& name) {
  for (const hal::ColourLook& look : hal::colour_looks)
    if (look.name == name) return look.colour;
  throw std::runtime_error(fmt::format("drew in an unknown colour '{}'; docs/writing-a-scenario.md lists them", name));
}

std::string encode_frame(const lab::Lab& lab, const hal::PoseFrame& frame, std::span<const hal::FromRobot> heard) {
  std::string out;
  put(out, std::int64_t{frame.stamp.count()});
  put(out, frame.number);
  const hal::Projection& projection = lab.projection();
  put_robots(out, frame.robots, [&](const hal::Observation& seen) {
    return Seen{seen.robot, seen.pose, projection.to_shared(seen.pose), seen.led};
  });
  put(out, static_cast<std::uint32_t>(frame.objects.size()));
  for (const hal::ObjectObservation& object : frame.objects)
    for (const double number : {object.pose.x_m, object.pose.y_m, object.pose.heading_rad}) put(out, number);
  put(out, static_cast<std::uint32_t>(heard.size()));
  for (const hal::FromRobot& said : heard) {
    put(out, said.robot);
    put(out, std::uint32_t{said.kind});
    put(out, said.value);
  }
  return out;
}

std::string encode_period(const lab::Lab& lab, std::span<const std::string> initial_only) {
  std::string out;
  put(out, std::int64_t{lab.now().count()});
  put(out, lab.period());
  const hal::Projection& projection = lab.projection();
  for (const std::string& each : lab.labs()) {
    const lab::LabState& state = lab.state(each);
    put_robots(out, state.robots, [&](const lab::SharedRobot& robot) {
      return Seen{robot.robot, projection.to_arena(robot.in_shared), robot.in_shared, robot.led};
    });
    std::vector<std::pair<std::string_view, std::span<const std::int64_t>>> fields(state.fields.begin(),
                                                                                   state.fields.end());
    for (const std::string& name : initial_only)
      if (!state.fields.contains(name)) fields.emplace_back(name, lab.initial_field(each, name));
    put(out, static_cast<std::uint32_t>(fields.size()));
    for (const auto& [name, values] : fields) {
      put(out, static_cast<std::uint8_t>(name.size()));
      out += name;
      put(out, static_cast<std::uint32_t>(values.size()));
      for (const std::int64_t value : values) put(out, value);
    }
  }
  return out;
}

std::string_view words_of(std::string_view answer) {
  return answer.substr(sizeof(std::uint32_t), size_of_words(answer));
}

std::string_view rest_of(std::string_view answer) {
  return answer.substr(sizeof(std::uint32_t) + size_of_words(answer));
}

Word decode_word(std::string_view bytes) {
  Word word;
  std::memcpy(&word.message.robot, bytes.data(), 4);
  word.message.slot = static_cast<std::uint8_t>(bytes[4]);
  word.message.kind = static_cast<std::uint8_t>(bytes[5]);
  word.how = static_cast<Word::How>(bytes[6] & 3);
  std::memcpy(&word.message.value, bytes.data() + 8, 4);
  return word;
}

}  // namespace arkmesh::scenarios::python
