// Converts lab values to LCM messages and back, field by field. Checks nothing but what a value cannot hold.
#include "hal/arenas/messages.hpp"

#include <algorithm>
#include <limits>

namespace arkmesh::hal {

namespace {

constexpr std::size_t robots_per_part = 1000;

// 36 minutes at most.
std::int32_t age_us(LabTime age) {
  return static_cast<std::int32_t>(std::min<std::int64_t>(age.count(), std::numeric_limits<std::int32_t>::max()));
}

solid_t to_message(const Shape& shape, const Pose& pose, std::vector<point_t>& corners) {
  solid_t out{};
  out.x_m = pose.x_m;
  out.y_m = pose.y_m;
  out.heading_rad = pose.heading_rad;
  out.radius_m = shape.radius_m;
  out.first_corner = static_cast<std::int32_t>(corners.size());
  out.n_corners = static_cast<std::int32_t>(shape.corners.size());
  for (const Point& corner : shape.corners) {
    point_t& point = corners.emplace_back();
    point.x_m = corner.x_m;
    point.y_m = corner.y_m;
  }
  return out;
}

robot_pose_t to_message(const Observation& observation) {
  robot_pose_t out;
  out.robot = observation.robot;
  out.x_m = observation.pose.x_m;
  out.y_m = observation.pose.y_m;
  out.heading_rad = observation.pose.heading_rad;
  out.led = static_cast<std::uint8_t>(observation.led);
  out.confidence = observation.confidence;
  out.age_us = age_us(observation.age);
  return out;
}

Observation from_message(const robot_pose_t& pose) {
  Observation out;
  out.robot = static_cast<RobotId>(pose.robot);
  out.pose = {pose.x_m, pose.y_m, pose.heading_rad};
  out.led = led_of(pose.led);
  out.confidence = pose.confidence;
  out.age = LabTime{pose.age_us};
  return out;
}

}  // namespace

std::vector<pose_frame_t> to_messages(const PoseFrame& frame) {
  const std::size_t robots = frame.robots.size();
  std::vector<object_pose_t> objects;
  for (const ObjectObservation& observation : frame.objects) {
    object_pose_t& object = objects.emplace_back();
    object.x_m = observation.pose.x_m;
    object.y_m = observation.pose.y_m;
    object.heading_rad = observation.pose.heading_rad;
    object.confidence = observation.confidence;
    object.age_us = age_us(observation.age);
  }
  const std::size_t parts = std::max<std::size_t>(1, (robots + robots_per_part - 1) / robots_per_part);
  std::vector<pose_frame_t> out(parts);
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t from = part * robots_per_part, to = std::min(robots, from + robots_per_part);
    pose_frame_t& message = out[part];
    message.stamp_us = frame.stamp.count();
    message.number = static_cast<std::int32_t>(frame.number);
    message.part = static_cast<std::int32_t>(part);
    message.parts = static_cast<std::int32_t>(parts);
    message.n_objects = 0;
    message.n_robots = static_cast<std::int32_t>(to - from);
    message.robots.reserve(to - from);
    for (std::size_t i = from; i < to; ++i) message.robots.push_back(to_message(frame.robots[i]));
  }
  out.front().n_objects = static_cast<std::int32_t>(objects.size());
  out.front().objects = std::move(objects);
  return out;
}

PoseFrame from_message(const pose_frame_t& part) {
  PoseFrame out;
  out.stamp = LabTime{part.stamp_us};
  out.number = static_cast<std::uint32_t>(part.number);
  for (const object_pose_t& object : part.objects)
    out.objects.push_back({{object.x_m, object.y_m, object.heading_rad}, object.confidence, LabTime{object.age_us}});
  out.robots.reserve(part.robots.size());
  for (const robot_pose_t& pose : part.robots) out.robots.push_back(from_message(pose));
  return out;
}

to_robots_t to_message(std::span<const ToRobot> messages, LabTime stamp, std::uint32_t frame) {
  to_robots_t out;
  out.stamp_us = stamp.count();
  out.frame = static_cast<std::int32_t>(frame);
  out.messages.reserve(messages.size());
  for (const ToRobot& each : messages) {
    if (each.whole) {
      whole_to_robot_t& whole = out.whole.emplace_back();
      whole.robot = static_cast<std::int32_t>(each.robot);
      whole.slot = each.slot;
      whole.type = each.whole->type;
      std::ranges::copy(each.whole->data, whole.data);
    } else {
      to_robot_t& word = out.messages.emplace_back();
      word.robot = static_cast<std::int32_t>(each.robot);
      word.slot = each.slot;
      word.kind = each.kind;
      word.value = static_cast<std::int32_t>(each.value);
    }
  }
  out.n_messages = static_cast<std::int32_t>(out.messages.size());
  out.n_whole = static_cast<std::int32_t>(out.whole.size());
  return out;
}

std::vector<ToRobot> from_message(const to_robots_t& message) {
  std::vector<ToRobot> out;
  out.reserve(message.messages.size() + message.whole.size());
  for (const to_robot_t& m : message.messages)
    out.push_back({static_cast<RobotId>(m.robot), m.slot, m.kind, static_cast<std::uint32_t>(m.value)});
  for (const whole_to_robot_t& m : message.whole) {
    ToRobot& whole = out.emplace_back();
    whole.robot = static_cast<RobotId>(m.robot);
    whole.slot = m.slot;
    whole.whole = WholeMessage{.type = m.type};
    std::ranges::copy(m.data, whole.whole->data.begin());
  }
  return out;
}

from_robots_t to_message(std::span<const FromRobot> messages, LabTime stamp) {
  from_robots_t out;
  out.stamp_us = stamp.count();
  out.n_messages = static_cast<std::int32_t>(messages.size());
  out.messages.resize(messages.size());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    out.messages[i].robot = messages[i].robot;
    out.messages[i].kind = messages[i].kind;
    out.messages[i].value = messages[i].value;
  }
  return out;
}

fleet_command_t to_message(const FleetCommand& command, LabTime stamp) {
  fleet_command_t out;
  out.stamp_us = stamp.count();
  out.command = static_cast<std::uint8_t>(command.kind);
  out.type = command.type;
  std::copy(command.data.begin(), command.data.end(), out.data);
  return out;
}

std::optional<FleetCommand> from_message(const fleet_command_t& message) {
  if (message.command > static_cast<std::uint8_t>(FleetCommand::Kind::broadcast) || message.type > 127) return {};
  FleetCommand out;
  out.kind = static_cast<FleetCommand::Kind>(message.command);
  out.type = message.type;
  std::copy(message.data, message.data + out.data.size(), out.data.begin());
  return out;
}

not_standing_t to_message(const NotStanding& robot) {
  not_standing_t out;
  out.robot = static_cast<std::int32_t>(robot.robot);
  out.why = static_cast<std::uint8_t>(robot.why);
  return out;
}

NotStanding from_message(const not_standing_t& robot) {
  const bool known = robot.why <= static_cast<std::uint8_t>(NotStanding::Why::not_named);
  return {static_cast<RobotId>(robot.robot),
          known ? static_cast<NotStanding::Why>(robot.why) : NotStanding::Why::not_in_sight};
}

arena_info_t to_message(const ArenaInfo& info) {
  arena_info_t out;
  out.lab = info.name;
  out.platform = info.platform;
  out.width_m = info.width_m;
  out.height_m = info.height_m;
  out.can_wait = info.can_wait;
  out.frame_period_us = info.frame_period.count();
  out.robots = static_cast<std::int32_t>(info.robots.size());
  out.max_robot = info.max_robot;
  out.kinds = info.kinds;
  out.values = static_cast<std::int32_t>(info.values);
  for (const Obstacle& obstacle : info.obstacles)
    out.solids.push_back(to_message(obstacle.shape, obstacle.pose, out.corners));
  for (const MovableObject& object : info.objects) {
    solid_t& solid = out.solids.emplace_back(to_message(object.shape, object.start, out.corners));
    solid.mass_kg = object.mass_kg;
    solid.friction = object.friction;
    out.object_names.push_back(object.name);
  }
  out.n_solids = static_cast<std::int32_t>(out.solids.size());
  out.n_corners = static_cast<std::int32_t>(out.corners.size());
  out.n_objects = static_cast<std::int32_t>(info.objects.size());
  out.body_radius_m = info.body_radius_m;
  out.id_bits = info.id_bits;
  out.kind_bits = info.kind_bits;
  out.message_type = info.message_type;
  out.whole = static_cast<std::uint8_t>(info.whole);
  out.make = info.make;
  out.body_height_m = static_cast<const RobotKind&>(info).height_m;
  return out;
}

bool read_solids(const arena_info_t& message, ArenaInfo& info) {
  const std::size_t objects = message.object_names.size();
  if (objects > message.solids.size()) return false;
  const std::size_t obstacles = message.solids.size() - objects;
  for (std::size_t i = 0; i < message.solids.size(); ++i) {
    const solid_t& solid = message.solids[i];
    if (solid.first_corner < 0 || solid.n_corners < 0 ||
        static_cast<std::size_t>(solid.first_corner) + static_cast<std::size_t>(solid.n_corners) >
            message.corners.size())
      return false;
    Shape shape{solid.radius_m, {}};
    for (std::int32_t k = 0; k < solid.n_corners; ++k) {
      const point_t& corner = message.corners[static_cast<std::size_t>(solid.first_corner + k)];
      shape.corners.push_back({corner.x_m, corner.y_m});
    }
    const Pose pose{solid.x_m, solid.y_m, solid.heading_rad};
    if (i < obstacles)
      info.obstacles.push_back({std::move(shape), pose});
    else
      info.objects.push_back(
          {message.object_names[i - obstacles], std::move(shape), pose, solid.mass_kg, solid.friction});
  }
  return true;
}

std::vector<counter_t> to_message(const Counters& counters) {
  std::vector<counter_t> out;
  out.reserve(counters.all().size());
  for (const auto& [name, total] : counters.all()) {
    counter_t& counter = out.emplace_back();
    counter.name = name;
    counter.value = static_cast<std::int64_t>(total);
  }
  return out;
}

}  // namespace arkmesh::hal
